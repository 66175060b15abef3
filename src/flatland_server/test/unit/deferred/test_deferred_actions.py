"""DeferredActions alone: which actions run at once, which later, and in what order."""

from typing import Callable, List

import pytest
from deferred.stage import errors

from flatland_server.exceptions import ModelError
from flatland_server.simulation.deferred_actions import MAX_ACTIONS_PER_RUN, DeferredActions


@pytest.fixture
def deferred() -> DeferredActions:
    return DeferredActions()


@pytest.fixture
def done() -> List[str]:
    """The names of the actions that have run, in their order."""
    return []


@pytest.fixture
def request_action(deferred, done) -> Callable[..., None]:
    """Requests an action that notes its name."""

    def request(name: str, **options: str) -> None:
        deferred.run_or_defer(lambda: done.append(name), f"{name} fails", **options)

    return request


def test_an_action_runs_at_once_and_its_result_is_returned(deferred):
    assert deferred.run_or_defer(lambda: "result", "fails") == "result"


def test_actions_wait_in_order_until_the_lock_is_released_and_pending_ones_are_run(
    deferred, request_action, done
):
    with deferred.lock:
        assert deferred.run_or_defer(lambda: done.append("a"), "fails") is None
        request_action("b")
        deferred.run_pending()
        assert done == []
    assert done == []

    deferred.run_pending()

    assert done == ["a", "b"]


def test_locks_nest(deferred, request_action, done):
    with deferred.lock:
        with deferred.lock:
            request_action("a")
        assert deferred.is_locked
        deferred.run_pending()
        assert done == []
    assert not deferred.is_locked


def test_a_lock_is_released_by_an_exception_and_the_actions_are_kept(
    deferred, request_action, done
):
    def interrupted_step() -> None:
        with deferred.lock:
            request_action("a")
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        interrupted_step()
    deferred.run_pending()

    assert done == ["a"]


def test_only_actions_on_the_changing_model_itself_wait_for_it(deferred, request_action, done):
    with deferred.changing("robot"):
        request_action("delete robot", unless_changing="robot")
        request_action("delete other", unless_changing="other")
        request_action("spawn")
        assert done == ["delete other", "spawn"]
    assert done == ["delete other", "spawn"]

    deferred.run_pending()

    assert done == ["delete other", "spawn", "delete robot"]


def test_deferred_actions_wait_until_no_model_is_changing(deferred, request_action, done):
    with deferred.changing("a"):
        request_action("delete a", unless_changing="a")
        with deferred.changing("b"):
            request_action("delete b", unless_changing="b")
        request_action("spawn")  # runs those that it has caused, but not the deferred ones
        assert done == ["spawn"]

    deferred.run_pending()

    assert done == ["spawn", "delete a", "delete b"]


def test_an_action_that_runs_at_once_is_followed_by_those_that_it_has_deferred(
    deferred, request_action, done
):
    def remove_bodies() -> None:
        with deferred.lock:
            request_action("second")
        done.append("first")

    deferred.run_or_defer(remove_bodies, "fails")

    assert done == ["first", "second"]


def test_actions_that_are_deferred_by_deferred_actions_run_after_all_others(
    deferred, request_action, done
):
    def first() -> None:
        with deferred.changing("robot"):
            request_action("third", unless_changing="robot")
        deferred.run_pending()
        done.append("first")

    with deferred.lock:
        deferred.run_or_defer(first, "fails")
        request_action("second")
    deferred.run_pending()

    assert done == ["first", "second", "third"]


def test_an_action_that_fails_at_once_raises(deferred, caplog):
    def fail() -> None:
        raise ModelError("no luck")

    with pytest.raises(ModelError, match="no luck"):
        deferred.run_or_defer(fail, "the action fails")

    assert errors(caplog) == []


def test_a_deferred_action_that_fails_is_logged_and_the_next_ones_run(
    deferred, request_action, done, caplog
):
    def fail() -> None:
        raise ModelError("no luck")

    with deferred.lock:
        deferred.run_or_defer(fail, "the action fails")
        request_action("next")
    deferred.run_pending()

    assert errors(caplog) == ["the action fails: no luck"]
    assert done == ["next"]


def test_an_unexpected_exception_of_a_deferred_action_is_raised_and_the_others_are_kept(
    deferred, request_action, done
):
    def fail() -> None:
        raise ZeroDivisionError

    with deferred.lock:
        deferred.run_or_defer(fail, "the action fails")
        request_action("next")
    with pytest.raises(ZeroDivisionError):
        deferred.run_pending()
    assert done == []

    deferred.run_pending()

    assert done == ["next"]


def test_actions_without_end_are_spread_over_runs(deferred):
    count = 0

    def repeat() -> None:
        nonlocal count
        count += 1
        with deferred.lock:
            deferred.run_or_defer(repeat, "fails")

    with deferred.lock:
        deferred.run_or_defer(repeat, "fails")

    for runs in (1, 2):
        deferred.run_pending()
        assert count == runs * MAX_ACTIONS_PER_RUN


def test_dropped_actions_do_not_run(deferred, request_action, done):
    with deferred.lock:
        request_action("a")
    deferred.clear()

    deferred.run_pending()

    assert done == []
