"""Real-time priority for the simulation's thread: punctual steps on a busy machine."""

import logging
import os
import queue
import signal
import threading
import time
from types import FrameType
from typing import Optional

from flatland_server import _core
from flatland_server.plugins.plugin_on_stack import describe_running
from flatland_server.real_time_timer import RealTimeTimer

logger = logging.getLogger(__name__)

_PERIOD = 1.0
"""Time between two decisions [s of real time]."""

_MAX_LOAD = 0.5
"""Share of a core that the thread may use to have real-time priority."""

_MAX_BUSY_TIME = 2.0
"""CPU time that the thread may use between two decisions before it loses its priority [s]."""


class ThreadPriority:
    """Gives the calling thread real-time priority while it uses little of a core.

    Where all cores are busy, for instance with an rviz that renders in software, a thread that
    wakes up waits several milliseconds for a core: most of a step. With real-time priority, at its
    lowest level, it does not wait. This needs a right, which root has, and others by `rtprio` in
    limits.conf; without it, everything stays as it is. A simulation that is busy most of the time,
    for instance at full speed, does not get the priority: other processes would starve.

    A thread that computes for 2 s without calling `update`, for instance in a plugin with an
    endless loop, loses the priority for the rest of the process's life, and the log names the
    plugin. Threads and processes that the thread starts do not inherit the priority.
    """

    def __init__(self) -> None:
        self._timer = RealTimeTimer(_PERIOD)
        self._since = time.monotonic()
        self._cpu_time = time.thread_time()
        self._is_preferred = False
        self._is_permitted = hasattr(os, "sched_setscheduler")  # on Linux
        self._guard: Optional[_core.PriorityGuard] = None

    def update(self) -> None:
        """Decides on the priority; to be called often, on the thread itself."""
        if not self._is_permitted or not self._timer.check_update():
            return
        if self._guard is not None and self._guard.has_fired:
            self._is_permitted = False
            return
        now, cpu_time = time.monotonic(), time.thread_time()
        if now <= self._since:
            return
        is_idle = cpu_time - self._cpu_time < _MAX_LOAD * (now - self._since)
        self._since, self._cpu_time = now, cpu_time
        if is_idle != self._is_preferred:
            self._prefer(is_idle)
        if self._is_preferred and self._guard is not None:
            self._guard.arm(_MAX_BUSY_TIME)

    def _prefer(self, wanted: bool) -> None:
        # SCHED_RESET_ON_FORK: threads and processes started by this one do not inherit it.
        policy = os.SCHED_RR | os.SCHED_RESET_ON_FORK if wanted else os.SCHED_OTHER
        try:
            if self._guard is None:
                self._guard = _guard_this_thread()
            if not wanted:
                self._guard.disarm()
            os.sched_setscheduler(0, policy, os.sched_param(1 if wanted else 0))
        except (OSError, RuntimeError) as error:
            self._is_permitted = False
            logger.debug("no real-time priority for the simulation's thread: %s", error)
        else:
            self._is_preferred = wanted


def _guard_this_thread() -> _core.PriorityGuard:
    """A guard that takes the priority away, and logs the code that this thread was running."""
    if threading.current_thread() is threading.main_thread():  # the one that runs Python's handlers
        # The handler may have interrupted code that holds a lock of logging or rospy: it only
        # hands the text over to a thread. SimpleQueue.put is reentrant.
        reports: queue.SimpleQueue[str] = queue.SimpleQueue()

        def report(_signal: int, frame: Optional[FrameType]) -> None:
            reports.put(describe_running(frame))

        signal.signal(signal.SIGXCPU, report)
        threading.Thread(target=_log_report, args=(reports,), daemon=True).start()
    return _core.PriorityGuard(signal.SIGXCPU)


def _log_report(reports: "queue.SimpleQueue[str]") -> None:
    logger.error(
        "the simulation's thread has lost its real-time priority until the server is restarted: "
        "%g s of CPU time without a break in %s",
        _MAX_BUSY_TIME,
        reports.get(),
    )
