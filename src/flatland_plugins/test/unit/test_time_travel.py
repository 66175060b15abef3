"""`seek` goes to any time of a run: each is what it was, bit for bit, and the run goes on."""

from dataclasses import replace

import numpy as np
import pytest
from test_branches import BOX, WORLDS, actions_of, physics

from flatland2d import Simulation, UsageError
from flatland_server import messages
from flatland_server.exceptions import StateError
from flatland_server.geometry import Pose
from flatland_server.simulation.world_config import ModelEntry

ALONE = "properties: {}\nlayers: [{name: map}]\nmodels: [{name: robot, model: robot.yaml}]\n"
PERIODS = [3, 7, 40, 13]
"""Steps between two commands."""


def drive(simulation, rounds, seed=0):
    """Drives at random; returns poses, velocities and ranges by time, as they are at commands."""
    robot, rng = simulation.models["robot"], np.random.default_rng(seed)
    seen = {}
    for k, command in enumerate(actions_of(simulation, rounds, rng)):
        if k % 3:
            robot.command(*command)
        else:
            simulation.publish("cmd_vel", twist(*command))
        simulation.step(PERIODS[k % len(PERIODS)])
        seen[simulation.time] = observed(simulation)
    return seen


def twist(vx, *rest):
    message = messages.get("geometry_msgs/Twist")()
    message.linear.x, message.angular.z = vx, rest[-1]
    return message


def observed(simulation):
    laser = simulation.models["robot"].sensors["laser"].read()
    return [simulation.poses, simulation.velocities, laser]


def assert_equal(found, expected):
    assert all(np.array_equal(*each) for each in zip(found, expected))


@pytest.fixture(params=WORLDS)
def world(request, world_of):
    return world_of(noise="0.02", **WORLDS[request.param])


def test_seek_restores_each_time_exactly(world):
    with Simulation(world, seed=3) as simulation:
        simulation.subscribe("scan", "odometry/filtered", "/tf")
        simulation.keep_history(interval=0.3)
        seen = drive(simulation, 40)
        last = simulation.save_state()

        times = list(seen)
        for time in np.random.default_rng(1).permutation(times[:-1])[:12]:
            assert simulation.seek(time).time == time
            assert_equal(observed(simulation), seen[time])
        assert simulation.seek(times[-1]).save_state() == last


def test_a_run_continues_from_a_sought_time_as_it_did_then(world):
    with Simulation(world, seed=3) as simulation, Simulation(world, seed=3) as other:
        simulation.keep_history(interval=0.3)
        drive(simulation, 23), drive(other, 13)
        present = other.time

        simulation.seek(present)
        for _ in range(2):
            expected = drive(other, 20, seed=1)
            found = drive(simulation, 20, seed=1)
            for time, values in expected.items():
                assert_equal(found[time], values)
        simulation.seek(present).seek(simulation.history.end)

        assert physics(simulation.save_state()) == physics(other.save_state())


@pytest.fixture
def simulation(world_of):
    with Simulation(world_of(models=ALONE)) as opened:
        opened.keep_history()
        yield opened


def test_other_times_can_be_sought_until_the_run_continues(simulation):
    simulation.step(700)
    simulation.seek(1.25)
    simulation.models["robot"].command(1.0, 0.0)  # counts once the run goes on
    assert (simulation.history.begin, simulation.history.end) == (0.0, 3.5)
    assert simulation.history.end > simulation.time
    simulation.seek(3.0).step(1)

    assert not simulation.models["robot"].velocity.vx
    assert simulation.history.end == simulation.time == pytest.approx(3.005)


def test_models_that_came_and_went_are_there_at_their_times(simulation):
    simulation.step(150)
    simulation.spawn(BOX, "box", (2, 0, 0))
    simulation.step(30)
    simulation.move("box", (3, 1, 0))
    simulation.step(30)
    simulation.delete("box")
    simulation.step(500)

    for time, expected in [(0.75, None), (0.8, (2, 0)), (0.9, (2, 0)), (0.95, (3, 1)), (1.1, None)]:
        box = simulation.seek(time).models.get("box")
        assert (box and box.pose[:2]) == expected, time
    assert "box" in simulation.seek(1.05).models
    assert "box" not in simulation.seek(simulation.history.end).models


@pytest.mark.parametrize(("memory", "forgets"), [(30_000, False), (9_000, True)])
def test_memory_is_bounded_and_each_time_left_is_exact(world_of, memory, forgets):
    """States are thinned out at first; if commands alone need more, the oldest are forgotten."""
    with Simulation(world_of(noise="0.02"), seed=3) as simulation:
        history = simulation.keep_history(interval=0.1, memory=memory)
        seen, largest = {}, 0
        for k in range(20):
            seen.update(drive(simulation, 8, seed=k))
            largest = max(largest, history.size)

        assert largest < memory + 40_000  # inputs that are not packed yet
        assert (history.begin > 0) == forgets
        assert history.begin < simulation.time * 0.8
        left = [time for time in seen if time >= history.begin]
        for time in left[:: len(left) // 10]:
            assert_equal(observed(simulation.seek(time)), seen[time])


def test_the_history_keeps_copies_of_messages(simulation):
    message, seen = twist(1.0, 0.0), {}
    for vx in (1.0, -0.5, 0.2):
        message.linear.x = vx
        simulation.publish("cmd_vel", message)
        simulation.step(50)
        seen[simulation.time] = simulation.poses

    for time, poses in seen.items():
        assert (simulation.seek(time).poses == poses).all()


def test_after_a_message_that_cannot_be_kept_there_is_a_state(simulation):
    class Local(type(twist(0.0, 0.0))):
        """A type that no other process could import."""

    message = Local()
    message.linear.x = 1.0
    simulation.step(20)
    simulation.publish("cmd_vel", message)
    simulation.step(50)
    poses = simulation.poses
    simulation.step(50)

    assert (simulation.seek(0.35).poses == poses).all()
    assert poses[0, 0] > 0.05


@pytest.mark.parametrize("is_in_past", [False, True])
def test_the_memory_is_bounded_in_a_pause(simulation, is_in_past):
    history, rng = simulation.keep_history(memory=50_000), np.random.default_rng(0)
    simulation.step(100)
    if is_in_past:
        simulation.seek(0.2)
    largest = 0
    for vx, turn in rng.uniform(-1.0, 1.0, (6000, 2)):
        simulation.publish("cmd_vel", twist(vx, turn))
        largest = max(largest, history.size)

    assert largest < 50_000 + 60_000  # inputs that are not compressed yet
    present = simulation.time
    with pytest.raises(UsageError, match=f"expected a time from {present} to {present} s"):
        simulation.seek(0.1)
    poses = simulation.step(300).poses
    assert history.begin == present
    assert (simulation.seek(present).seek(history.end).poses == poses).all()


def test_repeated_runs_from_one_time_need_no_more_memory(simulation):
    simulation.step(250)
    sizes = []
    for turn in np.linspace(-1.0, 1.0, 20):
        simulation.seek(1.13)
        for _ in range(5):
            simulation.models["robot"].command(0.5, turn)
            simulation.step(50)
        sizes.append(simulation.history.size)
    assert sizes[-1] < 1.2 * sizes[0]


@pytest.mark.parametrize("time", [1.05, 1.15])
def test_the_time_at_which_a_run_continued_is_not_thinned_out(simulation, time):
    history = simulation.keep_history(interval=0.1, memory=35_000)
    turn_at_random(simulation, 60, np.random.default_rng(0))
    simulation.seek(time)
    seen = turn_at_random(simulation, 250, np.random.default_rng(1))

    assert history.begin == 0.0
    for each in list(seen)[:20]:
        assert (simulation.seek(each).poses == seen[each]).all()


def turn_at_random(simulation, rounds, rng):
    """Commands the robot every 0.05 s; returns the poses by time."""
    seen = {}
    for turn in rng.uniform(-1.0, 1.0, rounds):
        simulation.models["robot"].command(0.5, turn)
        simulation.step(10)
        seen[simulation.time] = simulation.poses
    return seen


def test_states_are_thinned_out_after_the_oldest_were_forgotten(simulation):
    history, rng = simulation.keep_history(interval=0.1, memory=20_000), np.random.default_rng(0)
    while history.begin == 0.0:
        for vx, turn in rng.uniform(-1.0, 1.0, (20, 2)):
            simulation.publish("cmd_vel", twist(vx, turn))
        simulation.step(10)
    seen = {simulation.time: simulation.poses}
    begin = history.begin
    while history.begin == begin and simulation.time < 100.0:
        simulation.step(100)
        seen[simulation.time] = simulation.poses

    for time in [each for each in seen if each >= history.begin]:
        assert (simulation.seek(time).poses == seen[time]).all()
    assert simulation.seek(history.begin).time == history.begin


@pytest.mark.parametrize("seed", range(4))
def test_a_run_that_goes_back_and_on_at_random_is_what_it_was(world_of, seed):
    """With commands, messages, spawns and moves, in a memory that is soon full."""
    rng = np.random.default_rng(seed)
    with Simulation(world_of(noise="0.02"), seed=seed) as simulation:
        memory = int(rng.integers(15_000, 60_000))
        history = simulation.keep_history(interval=0.1, memory=memory)
        seen = {0.0: simulation.poses}
        for k in range(120):
            if rng.random() < 0.3:
                for time in rng.choice([each for each in seen if each >= history.begin], 3):
                    assert (simulation.seek(time).poses == seen[time]).all()
                if rng.random() < 0.7:
                    simulation.seek(history.end)
            seen = {time: poses for time, poses in seen.items() if time <= simulation.time}
            act(simulation, f"crate{k}", rng)
            simulation.step(int(rng.integers(1, 60)))
            seen[simulation.time] = simulation.poses


def act(simulation, name, rng):
    """Does one thing at random that comes from outside."""
    vx, turn = rng.uniform(-1.0, 1.0, 2)
    crates = [name for name in simulation.models if name.startswith("crate")]
    action = rng.choice(
        ["command", "publish", "spawn", "move", "delete"], p=[0.4, 0.3, 0.1, 0.1, 0.1]
    )
    if action == "command":
        simulation.models["robot"].command(vx, turn)
    elif action == "publish":
        simulation.publish("cmd_vel", twist(vx, turn))
    elif action == "spawn":
        simulation.spawn(BOX, name, (3 * vx, 3 * turn, 0))
    elif action == "move" and crates:
        simulation.move(crates[0], (3 * vx, 3 * turn, 0))
    elif crates:
        simulation.delete(crates[0])


@pytest.mark.parametrize("time", [-0.01, 2.51, np.nan, np.inf, "now", None])
def test_a_time_that_the_history_does_not_have_is_refused(simulation, time):
    simulation.step(500)
    with pytest.raises(UsageError, match=r"from 0 to 2\.5 s, which the history has"):
        simulation.seek(time)
    assert simulation.time == 2.5


@pytest.mark.parametrize("wrong", [{"interval": 0}, {"memory": -1}, {"memory": "all"}])
def test_a_history_of_wrong_arguments_is_refused(simulation, wrong):
    history = simulation.history
    with pytest.raises(UsageError, match=f"expected an? {next(iter(wrong))} above 0, found"):
        simulation.keep_history(**wrong)
    assert simulation.history is history


def test_without_a_history_there_is_nothing_to_seek(simulation):
    simulation.history.close()
    with pytest.raises(UsageError, match="expected keep_history"):
        simulation.seek(0.0)
    simulation.models["robot"].command(1.0, 0.0)
    assert simulation.step(10).history is None


def test_a_reset_begins_another_history(simulation):
    simulation.step(700)
    simulation.reset()
    simulation.step(100)
    assert (simulation.history.begin, simulation.history.end) == (0.0, 0.5)
    assert simulation.seek(0.2).time == pytest.approx(0.2)


def test_a_world_has_no_history_while_it_cannot_be_saved(simulation):
    simulation.step(10)
    config = replace(simulation.world.read_model(BOX), is_read=False)
    simulation.world.add_model(ModelEntry("toy", "", Pose(1, 1, 0), config))
    simulation.step(10)
    with pytest.raises(StateError, match=r'there is no history: .*"toy"'):
        simulation.seek(0.05)

    simulation.delete("toy")
    simulation.step(10)
    assert simulation.history.begin == pytest.approx(0.105)
    assert simulation.step(10).seek(0.16).time == pytest.approx(0.16)
