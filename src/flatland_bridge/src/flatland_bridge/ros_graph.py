"""The topics and services of a ROS master, those of Flatland's server among them."""

import threading
from collections import Counter
from typing import Any, Callable, Dict, List, Optional
from typing import Counter as CounterType

import rosgraph
import rospy

from flatland_bridge.budget import Budget
from flatland_bridge.client_calls import let_the_next_begin
from flatland_bridge.client_messages import require_type
from flatland_bridge.graph import Graph, Nodes, Receive, Topics
from flatland_bridge.parameters import ParameterError, Parameters
from flatland_bridge.ros_services import RosServices
from flatland_bridge.sample import Sample
from flatland_server.exceptions import MessageError
from flatland_server.messages import get, service_types
from flatland_server.ros import raw_messages
from flatland_server.ros.rospy_patches import master_calls

_ROSPY_SERVICES = ("/get_loggers", "/set_logger_level")  # of each node


class RosGraph(Graph):
    """Shows what the ROS master knows. The ROS node must be initialised.

    A topic is subscribed to, and its messages are sent over the network, while a client is.
    """

    def __init__(self) -> None:
        uri = rosgraph.get_master_uri()
        self._master = master_calls.Master(uri)
        self.parameters = MasterParameters(uri)
        self._lock = threading.RLock()
        self._topics = Topics({}, {})
        self._nodes = Nodes({}, {}, {})
        self._services = RosServices()
        self._subscriptions: Dict[str, _Subscription] = {}
        self._publishers: Dict[str, rospy.Publisher] = {}
        self._advertisers: CounterType[str] = Counter()  # clients, by topic

    def update(self) -> None:
        """Asks the master for topics and services; to be called from time to time, by one thread.

        If the master is stopped or gone, all stays as it is.
        """
        try:
            published, subscribed, services, types = self._master.graph()
            self._nodes = Nodes(dict(published), dict(subscribed), dict(services))
            known = {topic: kind for topic, kind in types.items() if _is_known(kind)}
            self._topics = Topics(
                *(
                    {topic: known[topic] for topic in sorted(dict(each)) if topic in known}
                    for each in (published, subscribed)
                )
            )
            # A master has one node for each service.
            nodes = {name: each[0] for name, each in services if not name.endswith(_ROSPY_SERVICES)}
            uris = self._master.uris(set(nodes.values()))
            registrations = [(name, uris[node]) for name, node in nodes.items() if node in uris]
            self._services.follow(registrations, self._master)
        except master_calls.NO_ANSWER:
            pass

    @property
    def topics(self) -> Topics:
        return self._topics

    @property
    def nodes(self) -> Nodes:
        return self._nodes

    @property
    def services(self) -> Dict[str, service_types.ServiceType]:
        return self._services.types

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

    def advertise(self, topic: str, message_type: Any) -> Callable[[], None]:
        with self._lock:
            if topic not in self._publishers:
                self._publishers[topic] = rospy.Publisher(topic, message_type, queue_size=10)
            self._advertisers[topic] += 1

        def end() -> None:
            with self._lock:
                self._advertisers[topic] -= 1
                if not self._advertisers[topic]:
                    del self._advertisers[topic]
                    self._publishers.pop(topic).unregister()

        return end

    def publish(self, topic: str, message: Any, client: Optional[Budget] = None) -> None:
        require_type(topic, self._topics.types.get(topic), message)
        self._publishers[topic].publish(message)

    def call(self, service: str, request: Any) -> Any:
        let_the_next_begin()  # it works elsewhere, and may wait there
        return self._services.call(service, self.service_type(service), request)


class MasterParameters(Parameters):
    """The parameters of a ROS master."""

    def __init__(self, uri: str) -> None:
        super().__init__()
        self._uri = uri

    def get(self, name: str, default: Any = None) -> Any:
        return self._ask("getParam", name, default=default)

    def names(self) -> List[str]:
        return list(self._ask("getParamNames"))

    def search(self, name: str) -> str:
        return str(self._ask("searchParam", name, default=""))

    def _put(self, name: str, value: Any) -> None:
        self._ask("setParam", name, value)

    def _remove(self, name: str) -> None:
        self._ask("deleteParam", name)

    def _ask(self, method: str, *arguments: Any, default: Any = None) -> Any:
        """The master's answer; the default if it says that there is no such parameter."""
        try:
            return master_calls.Master(self._uri).ask(method, *arguments, default=default)
        except master_calls.NO_ANSWER:
            raise ParameterError("the ROS master does not answer") from None


class _Subscription:
    """The subscription of all clients to a topic."""

    def __init__(self, topic: str, graph: RosGraph) -> None:
        self._topic = topic
        self._graph = graph
        self._lock = threading.Lock()
        self._receivers: List[Receive] = []
        self._latched: Dict[str, Sample] = {}  # the last one of each publisher
        self._subscriber = raw_messages.subscribe(topic, self._receive)

    def add(self, receive: Receive) -> None:
        """Adds a client, which gets latched messages first."""
        with self._lock:
            if receive not in self._receivers:
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

    def _receive(self, message: raw_messages.RawMessage) -> None:
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
