"""The end of the window's process, within the second and a half that roslaunch gives it."""

import logging
import os
import signal
import sys
import threading
import time
import xmlrpc.client
from contextlib import suppress
from typing import Any, Callable, List, NoReturn

import rosgraph
import rospy

from flatland_viz.native import library

_LIMIT = 2.0  # s


def shut_down(others: List[Callable[[], None]]) -> None:
    """Shuts down both ROS nodes of this process, rospy's and rviz's, and others, all at once.

    Each waits for the ROS master, for two seconds at most, and rospy also for a thread of its own
    that sleeps for half a second.

    Args:
        others: further functions that shut something down.
    """

    def rospy_node() -> None:
        rospy.signal_shutdown("the window is closed")

    rviz_node: Callable[[], object] = library().flatland_viz_shut_down_roscpp
    threads = [
        threading.Thread(target=each, daemon=True) for each in (*others, rospy_node, rviz_node)
    ]
    for thread in threads:
        thread.start()
    end = time.monotonic() + _LIMIT
    for thread in threads:
        thread.join(max(0.0, end - time.monotonic()))


def end_launch(server: Callable[[], None]) -> None:
    """Ends the roslaunch that has started this process, as Ctrl-C does; without one, the server.

    A server that ended first would be a "REQUIRED process" that "has died" to roslaunch.
    """
    launch = os.getppid()
    if launch in _launches():
        os.kill(launch, signal.SIGINT)
    else:
        server()


def _launches() -> List[int]:
    """The process ids of the roslaunch processes of this master, on any machine."""
    found: List[int] = []
    with suppress(OSError, xmlrpc.client.Error, rosgraph.MasterException):
        uris = rosgraph.Master(rospy.get_name()).getParam("/roslaunch/uris")
        for uri in uris.values():
            with suppress(OSError, xmlrpc.client.Error):  # it has ended
                answer: Any = xmlrpc.client.ServerProxy(uri).get_pid()
                found.append(answer[2])
    return found


def leave() -> NoReturn:
    """Ends the process with exit code 0, without freeing memory.

    rviz and OpenGL would take half a second for that.
    """
    logging.shutdown()
    sys.stdout.flush()
    sys.stderr.flush()
    os._exit(0)
