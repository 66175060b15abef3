"""Nodes that a signal ends, whatever they do then, and that may have no terminal."""

import atexit
import os
import queue
import signal
import sys
import threading

import rospy

from flatland_server.ros.rospy_patches import install


def open_closed_streams() -> None:
    """Opens standard output and errors if they are closed: rospy would fail to write to them."""
    for name in ("stdout", "stderr"):
        if getattr(sys, name) is None:
            setattr(sys, name, open(os.devnull, "w"))  # noqa: SIM115 (until the process ends)


def init_node(name: str) -> None:
    """Initializes the node; SIGINT and SIGTERM shut rospy down, on a thread of its own.

    rospy's handlers run on the main thread and call the master: if they interrupt another call to
    it, or a message that is being queued, they wait for ever for a lock that this thread holds.
    A second signal ends the process at once, since a master that is stopped answers no call.

    A message is in the subscriber's socket when `publish` returns. rospy's own would be with a
    thread, which may not run before the connections are closed: on a busy machine, more than half
    of the last messages were lost, such as commands to stop.

    Args:
        name: the node's name, if it is not remapped.
    """
    open_closed_streams()
    rospy.init_node(name, disable_signals=True)
    install(["nonblocking_connection"])
    reasons: queue.SimpleQueue[str] = queue.SimpleQueue()
    ending = threading.Thread(target=lambda: rospy.signal_shutdown(reasons.get()), daemon=True)

    def end(number: int, _frame: object) -> None:
        signal.signal(number, signal.SIG_DFL)
        reasons.put(f"signal {number}")  # which is reentrant

    def finish() -> None:
        """Waits for the end of a shutdown: the main thread may have nothing more to do before."""
        reasons.put("exit")
        ending.join()

    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, end)
    ending.start()
    atexit.register(finish)
