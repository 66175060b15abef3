"""Topics, transforms and parameters over ROS.

rospy calls back on threads of its own. Here a callback is only queued; it runs on the simulation's
thread when that calls `process`, so that a plugin never sees a half-stepped world or needs a lock.
"""

import logging
from collections import Counter, deque
from typing import Any, Callable, ContextManager, Deque, Dict, Mapping, Optional, Sequence, Tuple
from typing import Counter as CounterType

import rospy
from tf2_msgs.msg import TFMessage

from flatland_server._core import BodyMessage, StepMessage
from flatland_server.geometry import Transform
from flatland_server.messages.wire_form import LENGTH
from flatland_server.ros import raw_messages
from flatland_server.ros.clock import ClockPublisher
from flatland_server.ros.rospy_patches import RospyCalls
from flatland_server.ros.rospy_patches.rospy_calls import SubscriberCounter
from flatland_server.timekeeper import Timekeeper
from flatland_server.transport.arrivals import Arrival
from flatland_server.transport.claims import ANY_TYPE, type_name
from flatland_server.transport.served_transport import ServedTransport
from flatland_server.transport.transforms import (
    TF_STATIC,
    SerializedFrames,
    StaticTransforms,
    TransformQueue,
)
from flatland_server.transport.transport import Frames, MessageWriter, Publisher, Subscription

logger = logging.getLogger(__name__)

_REGISTRATION_LIMIT = 5.0
"""Real time that a service waits for the ROS master to register topics, before it answers [s]."""


class RosTransport(ServedTransport):
    """A transport over rospy. The ROS node must be initialised.

    Args:
        rospy_calls: the operations of rospy to use; by default without patches.
        own_params: private parameters that the node has read, such as "~no_return". The ROS
            master is not asked for them again: it may not answer, and each model that is spawned
            reads some.
    """

    def __init__(
        self,
        rospy_calls: RospyCalls = RospyCalls(),  # noqa: B008 (immutable)
        own_params: Optional[Mapping[str, Any]] = None,
    ) -> None:
        super().__init__()
        self._own_params = own_params or {}
        self.rospy_calls = rospy_calls
        """The operations of rospy in use."""
        self.can_forget = rospy_calls.forget_latched is not None
        self.has_started = False
        """True if the simulation runs, so that it checks `is_ending` regularly."""
        self.is_ending = False
        self.before_sending: Callable[[], None] = lambda: None
        """Called before messages are sent and callbacks are run, to send what must arrive first."""
        self._outbox = rospy_calls.outbox
        self._waiting: Deque[Callable[[], None]] = deque()
        self._transforms = TransformQueue()
        self._subscriber_counter = SubscriberCounter()
        self.publisher_counts: CounterType[str] = Counter()
        """The number of publishers of each topic, by its absolute name."""
        self._tf = rospy.Publisher(
            "/tf", TFMessage, self._subscriber_counter, queue_size=100, tcp_nodelay=True
        )
        self._static_transforms: Dict[str, StaticTransforms] = {}  # by topic

    @property
    def node_name(self) -> str:
        return str(rospy.get_name())

    def resolve(self, name: str) -> str:
        return str(rospy.resolve_name(name))  # with remappings

    def advertise(
        self, topic: str, message_type: Any, *, latch: bool, queue_size: int
    ) -> Publisher:
        name = rospy.resolve_name(topic)
        if f"/{topic}".endswith(TF_STATIC):
            if name not in self._static_transforms:
                self._static_transforms[name] = StaticTransforms(
                    lambda: rospy.Publisher(topic, TFMessage, latch=True, queue_size=10),
                    lambda: None,  # `release` publishes them: a world that is reset is one change
                )
            return self._static_transforms[name].advertise()
        # Publishers of a topic share what rospy has of it, and each would add the counter once
        # more: after a thousand resets, a subscriber would be counted a thousand times.
        counter = self._subscriber_counter if name not in self.publisher_counts else None
        publisher = rospy.Publisher(
            topic, message_type, counter, latch=latch, queue_size=queue_size, tcp_nodelay=True
        )
        self.publisher_counts[name] += 1
        return _RosPublisher(self, publisher, name)

    def subscribe(
        self, topic: str, message_type: Any, callback: Callable[[Any], None]
    ) -> Subscription:
        arrival = self.arrivals.open(rospy.resolve_name(topic), message_type)
        return _RosSubscription(topic, message_type, callback, self, arrival)

    @property
    def sends_bytes(self) -> bool:
        return True

    @property
    def transforms_have_subscribers(self) -> bool:
        return self.rospy_calls.is_connected(self._tf)

    @property
    def subscriber_revision(self) -> object:
        return self._subscriber_counter.revision

    def send_transform(self, transform: Transform) -> None:
        self._transforms.add(transform)

    def open_frames(self, names: Sequence[Tuple[str, str]]) -> Frames:
        return SerializedFrames(self._transforms, names)

    def get_param(self, name: str, default: Any = None) -> Any:
        if name in self._own_params:
            return self._own_params[name]
        return rospy.get_param(name, default)

    def process(self, timeout: float = 0.0) -> None:
        self.has_started = True
        if self._waiting:
            self._run_posted()
        if timeout <= 0.0:  # at full speed, this is called at each step
            self._outbox.is_open = self._outbox.can_hold
            return
        self.release()
        self._run_for(timeout)

    def end(self) -> None:
        """Makes the simulation end after the current wait of `process`; for any thread.

        Signal handlers may call it too. It takes no lock, hence does not wake `process`: the
        handler may have interrupted this very thread while it holds the lock.
        """
        self.is_ending = True

    def post(self, action: Callable[[], None]) -> None:
        self._waiting.append(action)
        self._arrival.set()

    def end_error(self) -> Exception:
        return rospy.ServiceException("the simulation is shutting down")

    def open_clock(self, timekeeper: Timekeeper) -> ClockPublisher:
        clock = ClockPublisher(timekeeper, self.rospy_calls)
        self.before_sending = clock.flush
        return clock

    def registration(self) -> ContextManager[None]:
        return self.rospy_calls.batch_registration()

    def wait_until_registered(self) -> bool:
        return self.rospy_calls.wait_until_registered(_REGISTRATION_LIMIT)

    def forget(self, publisher: Publisher) -> None:
        assert isinstance(publisher, _RosPublisher)
        if self.rospy_calls.forget_latched is not None:
            self.rospy_calls.forget_latched(publisher._publisher)

    def flush(self) -> None:
        self.arrivals.next_step()
        for send in self.on_flush:
            send()
        message, outbox = self._transforms.take(), self._outbox
        if message:
            if not outbox.is_open:
                self.before_sending()
            self.rospy_calls.send_framed(self._tf, LENGTH.pack(len(message)) + message)
        if outbox.is_open:
            if outbox.is_due():
                self.release()
            outbox.is_open = False
        elif not outbox.is_empty():
            self.release()

    def release(self) -> None:
        self._outbox.is_open = False
        for static in self._static_transforms.values():
            if static.is_changed:
                static.publish()
        self.before_sending()
        self._outbox.send()

    def _run_posted(self) -> None:
        self.release()
        while self._waiting and not self.is_ending:
            try:
                self._waiting.popleft()()
            except Exception:
                logger.exception("a callback failed")


class _RosPublisher(Publisher):
    def __init__(self, transport: RosTransport, publisher: rospy.Publisher, name: str) -> None:
        self._transport = transport
        self._publisher = publisher
        self._name = name
        self._outbox = transport.rospy_calls.outbox
        self._is_connected = transport.rospy_calls.is_connected
        self._send_framed = transport.rospy_calls.send_framed

    @property
    def has_subscribers(self) -> bool:
        return self._is_connected(self._publisher)

    def publish(self, message: Any) -> None:
        if not self._outbox.is_open:
            self._transport.before_sending()
        self._publisher.publish(message)

    def write(self, writer: MessageWriter, *values: Any) -> None:
        if self._is_connected(self._publisher):
            if not self._outbox.is_open:
                self._transport.before_sending()
            data = writer.data(*values)
            self._send_framed(self._publisher, LENGTH.pack(len(data)) + data)

    def step_message(self, message: BodyMessage) -> Optional[StepMessage]:
        return self._outbox.step_message(self._publisher, message)

    def close(self) -> None:
        self._publisher.unregister()
        counts = self._transport.publisher_counts
        counts[self._name] -= 1
        if counts[self._name] <= 0:
            del counts[self._name]


class _RosSubscription(Subscription):
    def __init__(
        self,
        topic: str,
        message_type: Any,
        callback: Callable[[Any], None],
        transport: RosTransport,
        arrival: Arrival,
    ) -> None:
        self._is_open = True
        self._topic = topic
        self._callback = callback
        self._transport = transport
        self._arrival = arrival

        def take(message: Any) -> None:
            transport.post(lambda: self._deliver(message))

        self._subscriber = (
            raw_messages.subscribe(topic, take)
            if type_name(message_type) == ANY_TYPE
            else rospy.Subscriber(topic, message_type, take)
        )

    def _deliver(self, message: Any) -> None:
        if self._is_open:
            self._arrival.note()
            note = self._transport.on_input
            if note is not None and self._transport.arrivals.is_first(self._arrival):
                note(self._topic, message)  # once, and not for each subscription
            self._callback(message)

    def close(self) -> None:
        self._is_open = False
        self._transport.arrivals.close(self._arrival)
        self._subscriber.unregister()
