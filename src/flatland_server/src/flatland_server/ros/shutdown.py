"""Signals and `rosnode kill`: end the simulation after the current step, if this step ends."""

import logging
import os
import queue
import signal
import sys
import threading
import time
from typing import Any, Optional

import rospy

from flatland_server.plugins.plugin_on_stack import describe_running
from flatland_server.ros.ros_transport import RosTransport

STEP_LIMIT = 1.0
"""Real time that the current step has to end after a signal [s]. scripts/run kills after 1.5 s."""
EXIT_LIMIT = 1.9
"""Real time from a signal to the end of the process at the latest [s]."""
_LOG_LIMIT = 0.3  # s
_ANSWER_LIMIT = 0.3  # s
_POLL_PERIOD = 0.01  # s; rospy has no event for the end of its shutdown

logger = logging.getLogger(__name__)


class Shutdown:
    """Handles the signals that end the node. Create it on the main thread, which simulates.

    rospy's own handler shuts down at once, on the main thread: if it interrupts a spawn that holds
    one of rospy's locks, it deadlocks. Here the current step is finished first. If the step does
    not end, for instance in a plugin with an endless loop, the process is ended. It is also ended
    if the shutdown takes too long: rospy waits for the ROS master, which may be stopped.

    While the world is loading there is no step to wait for: the process ends at once.

    rospy calls shutdown hooks in the order in which they were added. Create it before topics are
    opened and the patches installed, so that their hooks are called after the world is closed.
    """

    transport: Optional[RosTransport] = None
    """Ends the simulation; None while there is no simulation."""

    def __init__(self) -> None:
        # A signal handler must not take a lock that the code it interrupts may hold, and starting
        # a thread takes several; SimpleQueue.put is reentrant.
        self._signals: queue.SimpleQueue[int] = queue.SimpleQueue()
        self._steps_have_ended = threading.Event()
        self._world_is_closed = threading.Event()
        self._requester: Optional[threading.Thread] = None  # runs rospy's shutdown
        self._simulation = threading.get_ident()
        threading.Thread(target=self._limit_time, daemon=True).start()
        for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
            is_left_out = number == signal.SIGHUP and signal.getsignal(number) == signal.SIG_IGN
            if not is_left_out:  # by nohup
                signal.signal(number, self._end)
        rospy.on_shutdown(self._on_shutdown)

    def steps_have_ended(self) -> None:
        """To be called after the last step."""
        self._steps_have_ended.set()

    def finish(self) -> None:
        """Shuts rospy down, or waits until it is; to be called after the world is closed."""
        self._world_is_closed.set()
        rospy.signal_shutdown("the simulation has ended")
        while not rospy.is_shutdown():  # another thread shuts it down
            time.sleep(_POLL_PERIOD)
        if self._requester is not None:
            # It answers the request; then it may wait for another one on the same connection.
            self._requester.join(_ANSWER_LIMIT)

    def _end(self, number: int, _frame: Any) -> None:
        if self.transport is None or not self.transport.has_started:
            os._exit(0)
        self.transport.end()
        self._signals.put(number)

    def _on_shutdown(self) -> None:
        """Ends the simulation at the request of another process, on a thread of rospy's.

        Returns when the world is closed: rospy then unregisters what is still open.
        """
        if threading.get_ident() == self._simulation:
            if self.transport is not None:
                self.transport.end()  # service calls do not wait for it any longer
            return
        self._requester = threading.current_thread()
        self._end(signal.SIGTERM, None)
        self._world_is_closed.wait(STEP_LIMIT)

    def _limit_time(self) -> None:
        self._signals.get()
        exit_time = time.monotonic() + EXIT_LIMIT
        if not self._steps_have_ended.wait(STEP_LIMIT):
            self._exit(1, logging.CRITICAL, "the current step does not end")
        time.sleep(max(0.0, exit_time - time.monotonic()))
        self._exit(0, logging.WARNING, "the end takes too long")

    def _exit(self, code: int, level: int, reason: str) -> None:
        place = describe_running(sys._current_frames().get(self._simulation))
        # On a thread of its own: the simulation's may hold the lock of the log.
        message = f"{reason}: the process exits within {place}"
        log = threading.Thread(target=logger.log, args=(level, "%s", message), daemon=True)
        log.start()
        log.join(_LOG_LIMIT)
        os._exit(code)
