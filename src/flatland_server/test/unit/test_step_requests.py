"""Steps during a pause, and the messages that they wait for; on a simulated clock."""

import pytest

from flatland_server.exceptions import FlatlandError
from flatland_server.simulation.simulation_manager import SimulationManager
from flatland_server.simulation.world import World
from flatland_server.simulation.world_config import WorldConfig
from flatland_server.timekeeper import Timekeeper
from flatland_server.transport.local_transport import LocalTransport


class WaitingTransport(LocalTransport):
    """Waits on the simulated clock; `to_come` are the topics of messages that come at a round."""

    def __init__(self):
        super().__init__()
        self.now = 1000.0
        self.round = 0
        self.to_come = {}

        self.calls = []

    def release(self):
        self.calls.append("release")

    def process(self, timeout=0.0):
        self.calls.append("wait" if timeout > 0.0 else "no wait")
        self.now += timeout
        self.round += 1
        for topic in self.to_come.get(self.round, ()):
            self.send(topic, "go")
        super().process(timeout)


@pytest.fixture
def transport():
    return WaitingTransport()


@pytest.fixture
def manager(files, transport):
    """A paused simulation of an empty world with steps of 5 ms."""
    path = files.write("world.yaml", "properties: {}\nlayers: []\n")
    world = World(WorldConfig.from_file(path), transport)
    manager = SimulationManager(world, Timekeeper(0.005), clock=lambda: transport.now)
    manager.pause()
    return manager


def steps(manager):
    return manager.timekeeper.nanoseconds // 5_000_000


def run(manager, rounds):
    """Runs the loop for some rounds."""
    end = manager.world.transport.round + rounds
    manager.run(lambda: manager.world.transport.round < end)


def test_requested_steps_are_made_at_once_and_reported(manager, transport):
    ticks = []
    manager.on_tick.append(lambda: ticks.append((steps(manager), done.done(), transport.now)))
    done = manager.request_steps(100)
    begin = transport.now

    run(manager, 101)

    assert steps(manager) == 100
    assert done.result(0) == 500_000_000  # ns
    assert ticks[-1] == (100, False, begin)  # what the steps have published is sent before
    assert transport.returns_on_arrival is False
    run(manager, 5)
    assert steps(manager) == 100
    assert manager.is_paused


def test_messages_of_requested_steps_are_sent_before_the_report(manager, transport):
    manager.after_step.append(lambda: transport.calls.append("step"))
    done = manager.request_steps(3)
    done.add_done_callback(lambda _: transport.calls.append("report"))

    run(manager, 10)

    steps = ["no wait", "step"] * 3
    assert transport.calls[:8] == [*steps, "release", "report"]
    assert "no wait" not in transport.calls[8:]


def test_each_request_makes_its_steps(manager):
    for count in (1, 2, 3):
        done = manager.request_steps(count)
        run(manager, 5)
        assert done.done()
    assert steps(manager) == 6


@pytest.mark.parametrize("count", [0, -1])
def test_a_count_below_one_is_refused(manager, count):
    with pytest.raises(ValueError, match=f"expected 1 step or more, found {count}"):
        manager.request_steps(count)
    with pytest.raises(ValueError, match=f"a whole number of 1 or more, found {count}"):
        manager.step(count)
    manager.request_steps(1)  # the refused one is not pending


@pytest.mark.parametrize("timeout", [0.0, -1.0, float("nan")])
def test_a_timeout_that_is_not_above_zero_is_refused(manager, timeout):
    with pytest.raises(ValueError, match="expected a timeout above 0 s, found "):
        manager.request_steps(1, timeout=timeout)


def test_steps_are_refused_while_the_simulation_runs(manager):
    manager.resume()

    with pytest.raises(FlatlandError, match="the simulation is not paused"):
        manager.request_steps(1)


def test_a_second_request_is_refused_until_the_first_is_done(manager):
    refusals = []

    def request_again():
        if steps(manager) == 1:
            with pytest.raises(FlatlandError, match="the steps of another request are being made"):
                manager.request_steps(1)
            refusals.append(True)

    manager.after_step.append(request_again)
    done = manager.request_steps(3)

    run(manager, 10)

    assert refusals
    assert done.done()
    assert steps(manager) == 3


def test_steps_are_made_once_the_messages_have_come(manager, transport):
    transport.subscribe("/a", str, lambda _: None)
    transport.subscribe("/b", str, lambda _: None)
    transport.to_come = {3: ["/a"], 7: ["/b"]}
    counts = []
    manager.on_tick.append(lambda: counts.append((transport.round, steps(manager))))
    done = manager.request_steps(2, ["/a", "/b"])

    run(manager, 12)

    assert dict(counts)[6] == 0
    assert dict(counts)[8] == 2
    assert done.result(0) == 10_000_000  # ns


def test_messages_since_the_last_step_count_for_a_request(manager, transport):
    transport.subscribe("/a", str, lambda _: None)
    transport.send("/a", "early")
    run(manager, 1)
    assert manager.request_steps(1, ["/a"])
    run(manager, 3)
    assert steps(manager) == 1

    done = manager.request_steps(1, ["/a"], timeout=0.1)
    run(manager, 50)

    assert steps(manager) == 1
    with pytest.raises(FlatlandError, match="no message has come on /a since the last step"):
        done.result(0)


def test_a_pause_ends_a_request_that_waits_for_ever(manager, transport):
    transport.subscribe("/a", str, lambda _: None)
    done = manager.request_steps(1, ["/a"], timeout=float("inf"))
    manager.on_tick.append(manager.pause)

    run(manager, 50)

    with pytest.raises(FlatlandError, match="was paused before the steps were made"):
        done.result(0)
    assert steps(manager) == 0


def test_a_topic_without_a_subscription_is_refused(manager, transport):
    transport.subscribe("/cmd_vel", str, lambda _: None)

    message = r'subscribes to /cmd_val \(did you mean "/cmd_vel"\?\)'
    with pytest.raises(ValueError, match=message):
        manager.request_steps(1, ["/cmd_val"])


def test_all_subscriptions_of_a_topic_have_to_get_a_message(transport):
    first, second = transport.arrivals.open("/a"), transport.arrivals.open("/a")

    first.note()
    assert transport.arrivals.has_received("/a") is False
    second.note()
    assert transport.arrivals.has_received("/a") is True
    transport.flush()
    assert transport.arrivals.has_received("/a") is False
    first.note()
    transport.arrivals.close(second)
    assert transport.arrivals.has_received("/a") is True
    transport.arrivals.close(first)
    assert transport.arrivals.has_received("/a") is None


def test_a_request_ends_when_the_simulation_is_resumed(manager, transport):
    transport.subscribe("/a", str, lambda _: None)
    done = manager.request_steps(3, ["/a"])
    manager.resume()

    run(manager, 3)

    with pytest.raises(FlatlandError, match="was resumed before the steps were made"):
        done.result(0)
    assert steps(manager) == 2  # in real time


def test_a_request_ends_with_the_simulation(manager):
    done = manager.request_steps(100)

    run(manager, 3)

    with pytest.raises(FlatlandError, match="the simulation has ended"):
        done.result(0)


def test_several_steps_at_once_in_process(manager):
    manager.step(7)

    assert steps(manager) == 7


def test_a_reset_sets_the_clock_back_unless_it_is_kept(manager):
    jumps = []
    manager.after_jump.append(lambda: jumps.append(steps(manager)))
    manager.step(10)

    manager.reset(keep_time=True)
    manager.reset()
    manager.step(3)
    state = manager.save_state()
    manager.step(4)
    manager.load_state(state)
    manager.reload(manager.world.read_config())

    assert jumps == [10, 0, 3, 3]


def test_the_real_time_factor_is_not_negative_after_a_reset(manager):
    manager.resume()
    factors = []
    manager.on_tick.append(lambda: factors.append(manager.pacer.real_time_factor))
    run(manager, 1000)
    manager.after_step.append(lambda: steps(manager) == 500 and manager.reset())

    run(manager, 1500)

    assert min(factors[1:]) >= 0.0
    assert max(factors) == pytest.approx(1.0, abs=0.1)
