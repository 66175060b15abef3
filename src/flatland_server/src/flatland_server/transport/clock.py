"""/clock: simulated time for other nodes and clients."""

from flatland_server.messages.message_types import TYPES, get
from flatland_server.timekeeper import Timekeeper
from flatland_server.transport.transport import Transport


class Clock:
    """Publishes the time of each step."""

    def __init__(self, transport: Transport, timekeeper: Timekeeper) -> None:
        self._transport = transport
        self._timekeeper = timekeeper
        self._type = get("rosgraph_msgs/Clock")
        self._publisher = transport.advertise("/clock", self._type, latch=False, queue_size=100)
        self._served_revision = self._revision

    @property
    def _revision(self) -> object:
        """A value that changes when subscribers come."""
        return self._transport.subscriber_revision

    def tick(self) -> None:
        """Adds a message with the current time. To be called after each step."""
        self._served_revision = self._revision
        if self._publisher.has_subscribers:
            self._publisher.publish(self._type(TYPES.Time(0, self._timekeeper.nanoseconds)))

    def flush(self) -> None:
        """Sends the messages that are held back, if any are; to be called often."""

    def repeat_for_new_subscribers(self) -> None:
        """Sends the current time again if subscribers have come. To be called during a pause.

        A node that starts then would have no time until the next step: `rospy.sleep` and lookups of
        transforms would wait, and `rosbag record` would miss the messages of that step.
        """
        if self._served_revision != self._revision:
            self.tick()
            self.flush()
