"""The `actuators` of drives: their keys, and what they do through each of the doors."""

import math

import numpy as np
import pytest

from flatland2d import Simulation, SimulationBatch
from flatland_server import FlatlandError

G = 9.80665
DISC = {"type": "circle", "radius": 0.2, "density": 100}
LASER = {"type": "Laser", "name": "laser", "range": 5}
LASER["angle"] = {"min": -1, "max": 1, "increment": 0.5}


def world(actuators, walls=(), drive="DiffDrive", **changes):
    """A world with a robot of 12.6 kg."""
    keys = {"type": drive, "name": "drive", "body": "base", "actuators": actuators, **changes}
    body = {"name": "base", "footprints": [DISC]}
    model = {"bodies": [body], "plugins": [keys, {**LASER, "body": "base"}]}
    layers = [{"name": "map", "map": {"segments": list(walls)}}] if walls else []
    return {"properties": {}, "layers": layers, "models": [{"name": "robot", "model": model}]}


@pytest.mark.parametrize(
    ("actuators", "problem"),
    [
        ({"delay": 10.5}, "actuators.delay: expected 10 s at most, found 10.5"),
        ({"dely": 1}, 'actuators: unknown key "dely" (did you mean "delay"?)'),
        ({"linear": {"noise": -1}}, "actuators.linear.noise: expected a number of 0 or more"),
        ({"traction": {"mu": 1}}, 'actuators.traction: unknown key "mu"'),
        ({"traction": 0.5}, "actuators.traction: expected a map, found 0.5"),
        ({"max_force": math.nan}, "actuators.max_force: expected a number"),
        (3, "actuators: expected a map, found 3"),
    ],
)
def test_wrong_keys_are_refused(actuators, problem):
    with pytest.raises(FlatlandError) as caught:
        Simulation(world(actuators))

    assert problem in str(caught.value)


def test_a_limited_force_needs_a_mass(monkeypatch):
    monkeypatch.setitem(DISC, "density", 0)

    with pytest.raises(FlatlandError, match="needs a dynamic body with a density"):
        Simulation(world({"max_force": 5}))


@pytest.mark.parametrize("drive", ["DiffDrive", "OmniDrive"])
def test_the_keys_of_an_axis_default_to_those_of_all(drive):
    keys = {"delay": 0.1, "time_constant": 0.2, "angular": {"time_constant": 0}}
    with Simulation(world(keys, drive=drive)) as sim:
        robot = sim.models["robot"]
        command = (1.0, 0.5) if drive == "DiffDrive" else (1.0, 0.0, 0.5)
        robot.command(*command)
        sim.step(60)

        velocity = robot.model.base.physics_body.local_velocity
        assert velocity[0] == pytest.approx(1.0 - math.exp(-0.2 / 0.2), abs=1e-6)
        assert robot.pose.yaw == pytest.approx(0.5 * 0.2, abs=1e-6)


ALL = {
    "delay": 0.05,
    "time_constant": 0.1,
    "linear": {"dead_band": 0.02, "noise": 1e-3},
    "angular": {"dead_band": 0.05, "noise": 1e-3},
    "command_timeout": 0.5,
    "max_force": 40,
    "traction": {"friction": 0.5},
}


def run(sim, rounds):
    for number in rounds:
        sim.models["robot"].command(0.8, 0.4 * (number % 3 - 1))
        sim.step(20)
    return sim.models["robot"].pose


def test_a_batch_a_branch_and_a_saved_state_go_on_bit_for_bit():
    content = world(ALL, walls=[[0.9, -2, 0.9, 2]])
    actions = [np.array([[0.8, 0.4 * (number % 3 - 1)]] * 3) for number in range(30)]
    with Simulation(content, seed=5) as sim:
        run(sim, range(12))
        state = sim.save_state()
        with sim.branch(3) as branch:
            for each in actions[12:]:
                branched = branch.step(each, substeps=20).poses
        last = run(sim, range(12, 30))
        sim.load_state(state)
        again = run(sim, range(12, 30))
    with SimulationBatch(content, 3, seed=[5, 6, 5]) as batch:
        for each in actions:
            poses = batch.step(each, substeps=20).poses

    assert last.x > 0.5
    assert again == last
    assert branched.tolist() == [list(last)] * 3
    assert poses[[0, 2]].tolist() == [list(last)] * 2
    assert poses[1].tolist() != list(last)


# Friction lets it speed up by mu g: the wheels slip, and the odometry is of the wheels.
def test_odometry_is_that_of_wheels_that_slip():
    with Simulation(world({"traction": {"friction": 0.1}}, walls=[[1, -2, 1, 2]])) as sim:
        robot = sim.models["robot"]
        robot.command(2.0, 0.0)
        sim.step(40)

        assert robot.pose.x == pytest.approx(0.5 * 0.1 * G * 0.2**2, rel=0.03)
        measured = robot.sensors["drive"].read()
        assert measured.pose.x == pytest.approx(2.0 * 0.2, abs=1e-6)
        assert measured.velocity.vx == pytest.approx(2.0, abs=1e-6)
        sim.step(360)
        assert robot.pose.x == pytest.approx(0.8, abs=0.02)
        assert robot.sensors["drive"].read().pose.x == pytest.approx(4.0, abs=1e-5)
        truth = robot.sensors["drive"].read("ground_truth")
        assert truth.pose.x == robot.pose.x


def test_motors_that_stall_do_not_turn_the_wheels():
    keys = {"max_force": 5, "traction": {"friction": 0.9}}
    with Simulation(world(keys, walls=[[1, -2, 1, 2]])) as sim:
        sim.models["robot"].command(2.0, 0.0)
        sim.step(600)

        measured = sim.models["robot"].sensors["drive"].read()
        assert measured.pose.x == pytest.approx(sim.models["robot"].pose.x, abs=1e-4)


def test_without_commands_it_brakes_within_its_limits():
    limits = {"linear_dynamics": {"acceleration_limit": 2.0}}
    with Simulation(world({"command_timeout": 0.5}, **limits)) as sim:
        sim.models["robot"].command(1.0, 0.0)
        speeds = [sim.step(n).models["robot"].local_velocity.vx for n in (100, 50, 50)]
        assert speeds == pytest.approx([1.0, 0.5, 0.0])


def test_a_car_of_25_metres_a_second_is_not_held_back():
    with Simulation(world({}), step_size=0.1) as sim:
        sim.models["robot"].command(25.0, 0.0)
        sim.step(10)

        assert sim.models["robot"].pose.x == pytest.approx(25.0, abs=1e-4)
