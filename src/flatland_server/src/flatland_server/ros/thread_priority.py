"""Punctual steps on a machine that is busy."""

import logging
import os
import time

from flatland_server.ros.real_time_timer import RealTimeTimer

logger = logging.getLogger(__name__)

_PERIOD = 1.0
"""How often it is decided anew [s of real time]."""

_MOST_WORK = 0.5
"""How much of a core the simulation may need to be preferred."""


class ThreadPriority:
    """Has the system run the calling thread as soon as it is due, while it needs little of a core.

    Where all cores are busy, with an rviz that draws by software for instance, a thread that wakes
    up waits several milliseconds for its turn: most of a step. With real-time priority, the lowest
    there is, it does not. That needs a right: root has it, others by `rtprio` in limits.conf;
    without it, all stays as it is. A simulation that is busy most of the time, as at full speed,
    is not preferred: nobody else would come to his turn.
    """

    def __init__(self) -> None:
        self._timer = RealTimeTimer(_PERIOD)
        self._since = time.monotonic()
        self._worked = time.thread_time()
        self._is_preferred = False
        self._is_permitted = hasattr(os, "sched_setscheduler")  # on Linux

    def update(self) -> None:
        """Decides whether to be preferred; to be called often, on the thread itself."""
        if not self._is_permitted or not self._timer.check_update():
            return
        now, worked = time.monotonic(), time.thread_time()
        if now <= self._since:
            return
        is_idle = worked - self._worked < _MOST_WORK * (now - self._since)
        self._since, self._worked = now, worked
        if is_idle != self._is_preferred:
            self._prefer(is_idle)

    def _prefer(self, wanted: bool) -> None:
        # Threads and processes that this one starts are as others are.
        policy = os.SCHED_RR | os.SCHED_RESET_ON_FORK if wanted else os.SCHED_OTHER
        try:
            os.sched_setscheduler(0, policy, os.sched_param(1 if wanted else 0))
        except OSError as error:
            self._is_permitted = False
            logger.debug("the simulation's thread is not preferred: %s", error)
        else:
            self._is_preferred = wanted
