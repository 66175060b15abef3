"""Real-time priority of the simulation's thread: when it is given, and when it is taken away."""

import os
import subprocess
import sys
import threading
import time
from typing import Iterator, List

import pytest

from flatland_server.simulation import thread_priority
from flatland_server.simulation.thread_priority import ThreadPriority


class Machine:
    """A fake clock and a fake scheduler."""

    SCHED_OTHER, SCHED_RR, SCHED_RESET_ON_FORK = 0, 2, 0x40000000
    sched_param = staticmethod(int)

    def __init__(self) -> None:
        self.now = self.cpu_time = 100.0
        self.policies: List[str] = []
        self.permits = True

    def monotonic(self) -> float:
        return self.now

    def thread_time(self) -> float:
        return self.cpu_time

    def sched_setscheduler(self, thread: int, policy: int, priority: int) -> None:
        assert thread == 0  # the calling one
        name = {0: "usual", self.SCHED_RR | self.SCHED_RESET_ON_FORK: "real-time"}[policy]
        assert priority == (name == "real-time")
        self.policies.append(name)
        if not self.permits:
            raise PermissionError("not for you")


class Guard:
    """A fake of the core's guard."""

    def __init__(self) -> None:
        self.armed: List[float] = []
        self.has_fired = False

    def arm(self, seconds: float) -> None:
        self.armed.append(seconds)

    def disarm(self) -> None:
        self.armed.clear()


@pytest.fixture
def guard(monkeypatch):
    guard = Guard()
    monkeypatch.setattr(thread_priority, "_guard_this_thread", lambda: guard)
    return guard


@pytest.fixture
def machine(monkeypatch, guard):
    machine = Machine()
    monkeypatch.setattr(thread_priority, "os", machine)
    monkeypatch.setattr(thread_priority, "time", machine)
    monkeypatch.setattr("flatland_server.real_time_timer.time", machine)
    return machine


def pass_time(machine: Machine, priority: ThreadPriority, seconds: int, share: float) -> None:
    """Simulates a thread that is busy for a share of the time."""
    for _ in range(seconds * 100):
        machine.now += 0.01
        machine.cpu_time += 0.01 * share
        priority.update()


def test_the_priority_is_given_while_the_load_is_low(machine):
    priority = ThreadPriority()

    pass_time(machine, priority, 10, 0.1)
    assert machine.policies == ["real-time"]

    pass_time(machine, priority, 10, 0.9)  # at full speed, say
    assert machine.policies == ["real-time", "usual"]

    pass_time(machine, priority, 10, 0.4)
    assert machine.policies == ["real-time", "usual", "real-time"]


def test_a_busy_thread_never_gets_the_priority(machine):
    pass_time(machine, ThreadPriority(), 10, 1.0)

    assert machine.policies == []


def test_without_permission_it_is_tried_once(machine):
    machine.permits = False

    pass_time(machine, ThreadPriority(), 10, 0.1)

    assert machine.policies == ["real-time"]


def test_the_guard_is_rearmed_every_second_at_high_priority(machine, guard):
    priority = ThreadPriority()

    pass_time(machine, priority, 10, 0.1)
    assert guard.armed == [2.0] * 10

    pass_time(machine, priority, 2, 0.9)
    assert guard.armed == []


def test_a_priority_that_was_taken_away_is_not_given_again(machine, guard):
    priority = ThreadPriority()
    pass_time(machine, priority, 5, 0.1)

    guard.has_fired = True
    pass_time(machine, priority, 5, 0.9)
    pass_time(machine, priority, 5, 0.1)

    assert machine.policies == ["real-time"]


def test_the_system_gives_it_to_this_thread_alone():
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
        code = "import os; print(os.sched_getscheduler(0))"
        process = subprocess.run([sys.executable, "-c", code], stdout=subprocess.PIPE, check=True)
        others.append(int(process.stdout))

    thread = threading.Thread(target=run)
    thread.start()
    thread.join()

    if others == [-1]:
        pytest.skip("real-time priority is not allowed here")
    assert others == [os.SCHED_RR, os.SCHED_OTHER, os.SCHED_OTHER]
    assert os.sched_getscheduler(0) == os.SCHED_OTHER


ENDLESS = """
import itertools
import logging
import sys
import time

from flatland_server.plugins.model_plugin import ModelPlugin
from flatland_server.simulation import thread_priority
from flatland_server.transport.local_transport import LocalTransport
from flatland_server.transport.node import Node


class Endless(ModelPlugin):
    def python_code(self):
        while True:
            pass

    def native_code(self):
        sum(itertools.repeat(1))


logging.basicConfig()
plugin = Endless.__new__(Endless)
plugin.node = Node(LocalTransport(), owner="robot/endless")
thread_priority._MAX_BUSY_TIME = 0.3
priority = thread_priority.ThreadPriority()
deadline = time.monotonic() + 1.5
while time.monotonic() < deadline:
    time.sleep(0.01)
    priority.update()
print("ready", flush=True)
getattr(plugin, sys.argv[1])()
"""
LIMIT = 30.0  # s


@pytest.fixture
def start_endless() -> Iterator[object]:
    """Starts a process of which a plugin, with real-time priority, has an endless loop."""
    processes: List[subprocess.Popen[str]] = []

    def start(kind: str) -> "subprocess.Popen[str]":
        process = subprocess.Popen(
            [sys.executable, "-c", ENDLESS, kind],
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
        )
        processes.append(process)
        assert process.stdout.readline() == "ready\n"
        if not os.sched_getscheduler(process.pid) & os.SCHED_RR:
            pytest.skip("real-time priority is not allowed here")
        return process

    yield start
    for process in processes:
        process.kill()
        process.communicate()


@pytest.mark.slow
@pytest.mark.parametrize("kind", ["python_code", "native_code"])
def test_an_endless_plugin_loses_its_priority_and_is_named(start_endless, kind):
    process = start_endless(kind)

    deadline = time.monotonic() + LIMIT
    while os.sched_getscheduler(process.pid) & os.SCHED_RR and time.monotonic() < deadline:
        time.sleep(0.05)

    assert os.sched_getscheduler(process.pid) == os.SCHED_OTHER
    assert process.poll() is None
    if kind == "native_code":  # it is named once the native code has returned: never, here
        return
    line = process.stderr.readline()
    assert "has lost its real-time priority" in line
    assert 'the plugin "robot/endless" (<string>:15, in python_code)' in line
