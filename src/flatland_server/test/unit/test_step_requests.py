"""Steps during a pause, and the messages that they wait for; on a simulated clock."""

import math

import pytest
from simulated_clock import WaitingTransport, manager_on, steps

from flatland_server.exceptions import FlatlandError


@pytest.fixture
def transport():
    """Has a subscription of /a."""
    transport = WaitingTransport()
    transport.subscribe("/a", str, lambda _: None)
    return transport


@pytest.fixture
def manager(files, transport):
    """A paused simulation."""
    manager = manager_on(transport, files)
    manager.pause()
    return manager


def run(manager, rounds):
    """Runs the loop for some rounds."""
    waits = manager.transport.waits
    end = len(waits) + rounds
    manager.run(lambda: len(waits) < end)


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
    calls = []
    transport.release = lambda: calls.append("release")
    transport.meanwhile = lambda: calls.append("wait" if transport.waits[-1] else "no wait")
    manager.after_step.append(lambda: calls.append("step"))
    done = manager.request_steps(3)
    done.add_done_callback(lambda _: calls.append("report"))

    run(manager, 10)

    assert calls[:8] == [*["no wait", "step"] * 3, "release", "report"]
    assert "no wait" not in calls[8:]


def test_a_wrong_count_or_timeout_is_refused(manager):
    for count in (0, -1):
        with pytest.raises(ValueError, match=f"expected 1 step or more, found {count}"):
            manager.request_steps(count)
        with pytest.raises(ValueError, match=f"a whole number of 1 or more, found {count}"):
            manager.step(count)
    for timeout in (0.0, -1.0, math.nan):
        with pytest.raises(ValueError, match="expected a timeout above 0 s, found "):
            manager.request_steps(1, timeout=timeout)
    manager.request_steps(1)  # the refused one is not pending


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
    for total in (3, 5):
        done = manager.request_steps(total - steps(manager))
        run(manager, 10)
        assert (done.done(), steps(manager)) == (True, total)
    assert refusals


def test_steps_are_made_once_the_messages_have_come(manager, transport):
    to_come = {3: "/a", 7: "/b"}  # by round
    transport.subscribe("/b", str, lambda _: None)
    transport.meanwhile = lambda: transport.send(to_come.get(len(transport.waits), "/c"), "go")
    counts = {}
    manager.on_tick.append(lambda: counts.update({len(transport.waits): steps(manager)}))
    done = manager.request_steps(2, ["/a", "/b"])

    run(manager, 12)

    assert (counts[6], counts[8]) == (0, 2)
    assert done.result(0) == 10_000_000  # ns


def test_messages_since_the_last_step_count_for_a_request(manager, transport):
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
    first, second = transport.arrivals.open("/b"), transport.arrivals.open("/b")

    first.note()
    assert transport.arrivals.has_received("/b") is False
    second.note()
    assert transport.arrivals.has_received("/b") is True
    transport.flush()
    assert transport.arrivals.has_received("/b") is False
    first.note()
    transport.arrivals.close(second)
    assert transport.arrivals.has_received("/b") is True
    transport.arrivals.close(first)
    assert transport.arrivals.has_received("/b") is None


def test_a_request_ends_when_the_simulation_is_resumed(manager, transport):
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
