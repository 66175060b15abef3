"""Topics, transforms and parameters over ROS.

rospy calls back on threads of its own. Here a callback is only queued; it runs on the simulation's
thread when that calls `process`, so that no plugin ever sees a half-stepped world or needs a lock.
"""

import itertools
import logging
import threading
import time
from collections import deque
from typing import Any, Callable, Deque, Generic, List, Sequence, Tuple, TypeVar

import rospy
from tf2_msgs.msg import TFMessage

from flatland_server.geometry import Transform
from flatland_server.messages.serialized_transforms import SerializedFrames, TransformQueue
from flatland_server.ros.rospy_patches.nonblocking_connection import send_bytes
from flatland_server.transport.message_writer import MessageWriter
from flatland_server.transport.node import Frames, Publisher, Subscription, Transport

logger = logging.getLogger(__name__)

T = TypeVar("T")


class RosTransport(Transport):
    """A transport over rospy. The ROS node must be initialised."""

    def __init__(self) -> None:
        self._waiting: Deque[Callable[[], None]] = deque()
        self._arrival = threading.Event()
        self.has_started = False
        """Whether the simulation runs, and so comes by to look at `is_ending`."""
        self.is_ending = False
        self.before_sending: Callable[[], None] = lambda: None
        """Called before anything is sent, and before callbacks: by what has to arrive first."""
        self._transforms = TransformQueue()
        self._listeners = _Listeners()
        self._tf = rospy.Publisher(
            "/tf", TFMessage, self._listeners, queue_size=100, tcp_nodelay=True
        )

    def advertise(
        self, topic: str, message_type: Any, *, latch: bool, queue_size: int
    ) -> Publisher:
        return _RosPublisher(self, topic, message_type, latch, queue_size, self._listeners)

    def subscribe(
        self, topic: str, message_type: Any, callback: Callable[[Any], None]
    ) -> Subscription:
        return _RosSubscription(topic, message_type, callback, self.post)

    @property
    def transforms_have_subscribers(self) -> bool:
        return self._tf.get_num_connections() > 0

    @property
    def subscriber_revision(self) -> object:
        return self._listeners.version

    def send_transform(self, transform: Transform) -> None:
        self._transforms.add(transform)

    def open_frames(self, names: Sequence[Tuple[str, str]]) -> Frames:
        return SerializedFrames(self._transforms, names)

    def get_param(self, name: str, default: Any = None) -> Any:
        return rospy.get_param(name, default)

    def process(self, timeout: float = 0.0) -> None:
        self.has_started = True
        if self._waiting:
            self._run_callbacks()
        if timeout <= 0.0:
            return  # as quickly as can be: at full speed it comes by at each step
        deadline = time.monotonic() + timeout
        remaining = timeout
        while remaining > 0.0 and not self.is_ending:
            self._arrival.wait(remaining)
            self._arrival.clear()
            self._run_callbacks()
            remaining = deadline - time.monotonic()

    def end(self) -> None:
        """Lets the simulation end as soon as `process` has waited; may be called from anywhere.

        That is from a signal handler, too. It takes no lock, hence does not wake `process`: the
        handler may have interrupted this very thread while it holds the lock.
        """
        self.is_ending = True

    def post(self, callback: Callable[[], None]) -> None:
        """Has a callback run on the simulation's thread, between steps. For ROS's threads."""
        self._waiting.append(callback)
        self._arrival.set()

    def call(self, function: Callable[[], T]) -> T:
        """Runs a function on the simulation's thread, between steps, and returns its result.

        For ROS's threads; blocks until it is done. An exception is raised here.
        """
        errand = _Errand(function)
        self.post(errand.run)
        while not errand.is_done(0.1):
            if self.is_ending:
                raise rospy.ServiceException("the simulation is shutting down")
        return errand.result()

    def flush(self) -> None:
        message = self._transforms.take()
        if message:
            self.before_sending()
            send_bytes(self._tf, message)

    def _run_callbacks(self) -> None:
        self.before_sending()
        while self._waiting and not self.is_ending:
            try:
                self._waiting.popleft()()
            except Exception:
                logger.exception("a callback failed")


class _Errand(Generic[T]):
    """A function that one thread runs for another."""

    def __init__(self, function: Callable[[], T]) -> None:
        self._function = function
        self._outcome: List[Any] = []
        self._done = threading.Event()

    def run(self) -> None:
        try:
            self._outcome = [self._function(), None]
        except BaseException as error:
            self._outcome = [None, error]
        self._done.set()

    def is_done(self, timeout: float) -> bool:
        return self._done.wait(timeout)

    def result(self) -> T:
        value, error = self._outcome
        if error is not None:
            raise error
        return value


class _Listeners(rospy.SubscribeListener):  # type: ignore[misc]
    """Counts how often listeners have come or gone. ROS's threads call it."""

    def __init__(self) -> None:
        self._counter = itertools.count(1)
        self.version = 0

    def peer_subscribe(self, *_: Any) -> None:
        self.version = next(self._counter)

    def peer_unsubscribe(self, *_: Any) -> None:
        self.version = next(self._counter)


class _RosPublisher(Publisher):
    def __init__(
        self,
        transport: RosTransport,
        topic: str,
        message_type: Any,
        latch: bool,
        queue_size: int,
        listeners: _Listeners,
    ) -> None:
        self._transport = transport
        self._publisher = rospy.Publisher(
            topic,
            message_type,
            listeners,
            latch=latch,
            queue_size=queue_size,
            tcp_nodelay=True,
        )

    @property
    def has_subscribers(self) -> bool:
        return self._publisher.get_num_connections() > 0

    def publish(self, message: Any) -> None:
        self._transport.before_sending()
        self._publisher.publish(message)

    def write(self, writer: MessageWriter, *values: Any) -> None:
        if self.has_subscribers:
            self._transport.before_sending()
            send_bytes(self._publisher, writer.data(*values))

    def close(self) -> None:
        self._publisher.unregister()


class _RosSubscription(Subscription):
    def __init__(
        self,
        topic: str,
        message_type: Any,
        callback: Callable[[Any], None],
        enqueue: Callable[[Callable[[], None]], None],
    ) -> None:
        self._is_open = True
        self._callback = callback
        self._subscriber = rospy.Subscriber(
            topic, message_type, lambda message: enqueue(lambda: self._deliver(message))
        )

    def _deliver(self, message: Any) -> None:
        if self._is_open:
            self._callback(message)

    def close(self) -> None:
        self._is_open = False
        self._subscriber.unregister()
