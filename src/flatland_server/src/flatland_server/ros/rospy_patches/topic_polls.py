"""Topics without a file descriptor of their own.

rospy makes an epoll object for each topic, to find connections that were closed: with the usual
limit of 1,024 open files, some 150 robots fill a process with them. They are also kept in reference
cycles, so that the descriptors of a closed topic remain until the next garbage collection. poll(2)
does the same without a descriptor; rospy uses it itself where there is no epoll.
"""

import select
import threading
from typing import Any, Dict, Iterator

import rospy.topics

from flatland_server.ros.rospy_patches.rospy_checks import Requirement, check_all

REQUIREMENTS = (
    Requirement("rospy.topics:Poller.add_epoll", ("self", "fd")),
    Requirement("rospy.topics:Poller.remove_epoll", ("self", "fd")),
    Requirement("rospy.topics:Poller.error_epoll_iter", ("self",)),
    Requirement("rospy.topics:_TopicImpl.__init__", uses=("Poller", "connection_poll")),
)

_ENDED = select.POLLHUP | select.POLLERR | select.POLLRDHUP


def install() -> Dict[str, Any]:
    """Makes topics that are opened from now on use `Poller`. Replaces no call."""
    check_all(REQUIREMENTS)
    rospy.topics.Poller = Poller
    return {}


class Poller:
    """Finds ended connections, with the interface that rospy's topics use.

    rospy calls it in several threads: its own checks all topics, those of connections add theirs.
    poll(2) in Python refuses that, unlike epoll.
    """

    def __init__(self) -> None:
        self._poll = select.poll()
        self._lock = threading.Lock()

    def add_fd(self, fd: int) -> None:
        """Watches a connection."""
        with self._lock:
            self._poll.register(fd, _ENDED)

    def remove_fd(self, fd: int) -> None:
        """Stops watching a connection."""
        with self._lock:
            self._poll.unregister(fd)

    def error_iter(self) -> Iterator[int]:
        """The descriptors of the connections that have ended."""
        ended = []
        with self._lock:
            for fd, event in self._poll.poll(0):
                if event & select.POLLNVAL:  # closed meanwhile; epoll forgets such descriptors
                    self._poll.unregister(fd)
                elif event & _ENDED:
                    ended.append(fd)
        return iter(ended)
