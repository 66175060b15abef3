"""DeferredActions alone: which actions run at once, which later, and in what order."""

from typing import Callable, List

import pytest

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


def test_locks_nest(deferred, request_action, done):
    with deferred.lock:
        with deferred.lock:
            request_action("a")
        assert deferred.is_locked
        deferred.run_pending()
        assert done == []
    assert not deferred.is_locked


def test_an_exception_releases_the_lock_and_keeps_the_actions(deferred, request_action, done):
    def interrupted_step() -> None:
        with deferred.lock:
            request_action("a")
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        interrupted_step()
    deferred.run_pending()

    assert done == ["a"]


def test_actions_deferred_by_deferred_actions_run_last(deferred, request_action, done):
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


def test_a_failing_deferred_action_raises_and_keeps_the_others(deferred, request_action, done):
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
    deferred.drop("the world is gone")

    deferred.run_pending()

    assert done == []
