"""The topics and services of a ROS master, those of Flatland's server among them."""

import logging
import threading
from typing import Any, Callable, Dict, List, Optional

import rosgraph
import rospy
import rosservice

from flatland_bridge.budget import Budget
from flatland_bridge.client_calls import let_the_next_begin
from flatland_bridge.graph import BridgeError, Graph, Receive, Sample, Topics, require_type
from flatland_server.exceptions import MessageError
from flatland_server.messages import service_types
from flatland_server.messages.message_types import get

logger = logging.getLogger(__name__)

_ROSPY_SERVICES = ("/get_loggers", "/set_logger_level")  # of each node


class RosGraph(Graph):
    """Shows what the ROS master knows. The ROS node must be initialised.

    A topic is subscribed to, and its messages are sent over the network, while a client is.
    """

    def __init__(self) -> None:
        self._master = rosgraph.Master(rospy.get_name())
        self._lock = threading.RLock()
        self._topics = Topics({}, {})
        self._services: Dict[str, service_types.ServiceType] = {}
        self._subscriptions: Dict[str, _Subscription] = {}
        self._publishers: Dict[str, rospy.Publisher] = {}
        self._refused: Dict[str, None] = {}  # services of unknown types

    def update(self) -> None:
        """Asks the master for topics and services; to be called from time to time."""
        try:
            publishers, subscribers, services = self._master.getSystemState()
            types = dict(self._master.getTopicTypes())
        except OSError:
            return  # the master is stopped: all is as before
        known = {topic: kind for topic, kind in types.items() if _is_known(kind)}
        published, subscribed = (
            {topic: known[topic] for topic in sorted(dict(each)) if topic in known}
            for each in (publishers, subscribers)
        )
        self._topics = Topics(published, subscribed)
        names = [name for name, _ in services if not name.endswith(_ROSPY_SERVICES)]
        self._services = {
            name: kind for name in sorted(names) if (kind := self._type_of(name)) is not None
        }

    @property
    def topics(self) -> Topics:
        return self._topics

    @property
    def services(self) -> Dict[str, service_types.ServiceType]:
        return self._services

    @property
    def nanoseconds(self) -> int:
        return int(rospy.get_rostime().to_nsec())

    def subscribe(
        self, topic: str, receive: Receive, client: Optional[Budget] = None
    ) -> Callable[[], None]:
        with self._lock:
            subscription = self._subscriptions.get(topic)
            if subscription is None:
                subscription = self._subscriptions[topic] = _Subscription(topic, self)
            subscription.add(receive)

        def end() -> None:
            with self._lock:
                if subscription.remove(receive):
                    del self._subscriptions[topic]

        return end

    def advertise(self, topic: str, message_type: Any) -> None:
        with self._lock:
            if topic not in self._publishers:
                self._publishers[topic] = rospy.Publisher(topic, message_type, queue_size=10)

    def publish(self, topic: str, message: Any, client: Optional[Budget] = None) -> None:
        require_type(topic, self._topics.types.get(topic), message)
        self.advertise(topic, type(message))
        self._publishers[topic].publish(message)

    def call(self, service: str, request: Any) -> Any:
        kind = self.service_type(service)
        let_the_next_begin()  # it works elsewhere, and may wait there
        try:
            return rospy.ServiceProxy(service, kind.ros_class)(request)
        except (rospy.ROSException, rospy.ServiceException) as error:
            raise BridgeError(str(error)) from None

    def _type_of(self, service: str) -> Optional[service_types.ServiceType]:
        if service in self._services or service in self._refused:
            return self._services.get(service)
        try:
            return service_types.get(rosservice.get_service_type(service))
        except (MessageError, AttributeError, rosservice.ROSServiceException):
            self._refused[service] = None
            return None


class _Subscription:
    """The subscription of all clients to a topic.

    Args:
        topic: its absolute name.
        graph: has the time.
    """

    def __init__(self, topic: str, graph: RosGraph) -> None:
        self._topic = topic
        self._graph = graph
        self._lock = threading.Lock()
        self._receivers: List[Receive] = []
        self._latched: Dict[str, Sample] = {}  # the last one of each publisher
        self._subscriber = rospy.Subscriber(topic, rospy.AnyMsg, self._receive)

    def add(self, receive: Receive) -> None:
        """Adds a client, which gets latched messages first."""
        with self._lock:
            self._receivers.append(receive)
            for sample in self._latched.values():
                receive(sample)

    def remove(self, receive: Receive) -> bool:
        """Removes a client. Returns whether it was the last one, and the subscription ends."""
        with self._lock:
            if receive in self._receivers:
                self._receivers.remove(receive)
            is_last = not self._receivers
        if is_last:
            self._subscriber.unregister()
        return is_last

    def _receive(self, message: rospy.AnyMsg) -> None:
        header = message._connection_header
        try:
            kind = get(header["type"])
        except MessageError:
            return
        is_latched = header.get("latching") == "1"
        data = message._buff
        sample = Sample(
            self._topic, self._graph.nanoseconds, kind, data=data, is_latched=is_latched
        )
        with self._lock:
            if is_latched:
                self._latched[header["callerid"]] = sample
            for receive in self._receivers:
                receive(sample)


def _is_known(kind: str) -> bool:
    try:
        return kind != "*" and get(kind) is not None
    except MessageError:
        return False
