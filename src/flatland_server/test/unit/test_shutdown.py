"""The end by request of another process, such as rosnode kill or the window, without a master."""

import os
import signal
import threading
from types import SimpleNamespace

import pytest
import rospy

from flatland_server.ros import shutdown
from flatland_server.ros.shutdown import Shutdown

pytestmark = pytest.mark.filterwarnings("ignore::pytest.PytestUnhandledThreadExceptionWarning")


@pytest.fixture
def codes(monkeypatch):
    """The exit codes that were passed to os._exit, and an event for that."""
    codes = SimpleNamespace(list=[], event=threading.Event())

    def exit(code):
        codes.list.append(code)
        codes.event.set()
        raise SystemExit  # ends the thread that has called

    monkeypatch.setattr(os, "_exit", exit)
    return codes


@pytest.fixture
def request_end(monkeypatch, codes):
    """Makes a Shutdown and calls its hook as rospy does: on a thread of its own, unless told."""
    numbers = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)
    handlers = {number: signal.getsignal(number) for number in numbers}
    hooks, all_made = [], []
    monkeypatch.setattr(rospy, "on_shutdown", hooks.append)
    monkeypatch.setattr(shutdown, "STEP_LIMIT", 0.1)

    def make(has_started, on_this_thread=False, later_hook=None):
        transport = SimpleNamespace(has_started=has_started, is_ending=False)
        transport.end = lambda: setattr(transport, "is_ending", True)
        made = Shutdown()
        made.transport = transport
        all_made.append(made)
        if on_this_thread:
            hooks[-1]()
        elif later_hook is not None:
            threading.Thread(target=lambda: (hooks[-1](), later_hook())).start()
        else:
            thread = threading.Thread(target=hooks[-1])
            thread.start()
            thread.join()
        return made, transport

    yield make
    for made in all_made:
        made.steps_have_ended()  # its thread must not exit this process
    for number, handler in handlers.items():
        signal.signal(number, handler)


def test_while_the_world_is_loading_the_process_ends_at_once(request_end, codes):
    request_end(has_started=False)

    assert codes.list == [0]


def test_a_step_that_does_not_end_is_not_waited_for(request_end, codes):
    _, transport = request_end(has_started=True)

    assert transport.is_ending
    assert codes.event.wait(10)
    assert codes.list == [1]


def test_later_shutdown_hooks_run_and_are_waited_for(request_end, codes, monkeypatch):
    monkeypatch.setattr(shutdown, "STEP_LIMIT", 10.0)
    monkeypatch.setattr(shutdown, "EXIT_LIMIT", 0.0)
    monkeypatch.setattr(rospy, "signal_shutdown", lambda reason: None)  # it runs the hooks already
    order = []
    monkeypatch.setattr(rospy, "is_shutdown", lambda: "hook" in order)

    made, _ = request_end(has_started=True, later_hook=lambda: order.append("hook"))
    made.steps_have_ended()
    assert codes.event.wait(10)  # the hook has begun; nothing else may exit this process
    order.append("world closed")
    made.finish()

    assert order == ["world closed", "hook"]


def test_a_simulation_that_has_ended_is_not_disturbed(request_end, codes):
    made, transport = request_end(has_started=True, on_this_thread=True)
    made.steps_have_ended()

    assert transport.is_ending
    assert not codes.event.wait(0.3)


def test_a_hangup_that_nohup_ignores_stays_ignored(request_end):
    signal.signal(signal.SIGHUP, signal.SIG_IGN)

    request_end(has_started=True, on_this_thread=True)

    assert signal.getsignal(signal.SIGHUP) == signal.SIG_IGN
