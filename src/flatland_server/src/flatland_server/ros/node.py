"""Nodes that a signal ends, whatever they do then, and that may have no terminal."""

import os
import queue
import signal
import sys
import threading

import rospy


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

    Args:
        name: the node's name, if it is not remapped.
    """
    open_closed_streams()
    rospy.init_node(name, disable_signals=True)
    signals: queue.SimpleQueue[int] = queue.SimpleQueue()

    def end(number: int, _frame: object) -> None:
        signal.signal(number, signal.SIG_DFL)
        signals.put(number)  # which is reentrant

    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, end)
    threading.Thread(
        target=lambda: rospy.signal_shutdown(f"signal {signals.get()}"), daemon=True
    ).start()
