"""The simulation's thread is preferred while it needs little, and where that is allowed."""

import os
import threading
import time
from typing import List

import pytest

from flatland_server.ros import thread_priority
from flatland_server.ros.thread_priority import ThreadPriority


class Machine:
    """A clock and a scheduler of the test's own."""

    SCHED_OTHER, SCHED_RR, SCHED_RESET_ON_FORK = 0, 2, 0x40000000
    sched_param = staticmethod(int)

    def __init__(self) -> None:
        self.now = self.worked = 100.0
        self.asked: List[str] = []
        self.permits = True

    def monotonic(self) -> float:
        return self.now

    def thread_time(self) -> float:
        return self.worked

    def sched_setscheduler(self, thread: int, policy: int, priority: int) -> None:
        assert thread == 0  # the calling one
        name = {0: "usual", self.SCHED_RR | self.SCHED_RESET_ON_FORK: "preferred"}[policy]
        assert priority == (name == "preferred")
        self.asked.append(name)
        if not self.permits:
            raise PermissionError("not for you")


@pytest.fixture
def machine(monkeypatch):
    machine = Machine()
    monkeypatch.setattr(thread_priority, "os", machine)
    monkeypatch.setattr(thread_priority, "time", machine)
    monkeypatch.setattr("flatland_server.ros.real_time_timer.time", machine)
    return machine


def pass_time(machine: Machine, priority: ThreadPriority, seconds: int, share: float) -> None:
    """Lets time go by of which the thread works a share."""
    for _ in range(seconds * 100):
        machine.now += 0.01
        machine.worked += 0.01 * share
        priority.update()


def test_it_is_preferred_while_it_needs_little(machine):
    priority = ThreadPriority()

    pass_time(machine, priority, 10, 0.1)
    assert machine.asked == ["preferred"]

    pass_time(machine, priority, 10, 0.9)  # at full speed, say
    assert machine.asked == ["preferred", "usual"]

    pass_time(machine, priority, 10, 0.4)
    assert machine.asked == ["preferred", "usual", "preferred"]


def test_a_busy_one_is_never_preferred(machine):
    pass_time(machine, ThreadPriority(), 10, 1.0)

    assert machine.asked == []


def test_without_permission_it_does_not_ask_again(machine):
    machine.permits = False

    pass_time(machine, ThreadPriority(), 10, 0.1)

    assert machine.asked == ["preferred"]


def test_the_system_grants_it_to_this_thread_alone():
    others: List[int] = []

    def run() -> None:
        try:
            os.sched_setscheduler(0, os.SCHED_OTHER, os.sched_param(0))
            os.sched_setscheduler(0, os.SCHED_RR, os.sched_param(1))
            os.sched_setscheduler(0, os.SCHED_OTHER, os.sched_param(0))
        except OSError:
            others.append(-1)
            return
        priority = ThreadPriority()
        deadline = time.monotonic() + 10.0
        while not os.sched_getscheduler(0) & os.SCHED_RR and time.monotonic() < deadline:
            threading.Event().wait(0.01)
            priority.update()
        others.append(os.sched_getscheduler(0) & ~os.SCHED_RESET_ON_FORK)
        child = threading.Thread(target=lambda: others.append(os.sched_getscheduler(0)))
        child.start()
        child.join()

    thread = threading.Thread(target=run)
    thread.start()
    thread.join()

    if others == [-1]:
        pytest.skip("real-time priority is not allowed here")
    assert others == [os.SCHED_RR, os.SCHED_OTHER]
    assert os.sched_getscheduler(0) == os.SCHED_OTHER
