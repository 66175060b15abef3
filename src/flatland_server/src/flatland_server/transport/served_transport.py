"""The interface of a transport for a simulation that other threads talk to, and its /clock."""

import threading
import time
from abc import abstractmethod
from concurrent.futures import Future, wait
from contextlib import nullcontext
from typing import Callable, ContextManager, TypeVar

from flatland_server.messages.message_types import TYPES, get
from flatland_server.timekeeper import Timekeeper
from flatland_server.transport.transport import Publisher, Transport

T = TypeVar("T")

_END_CHECK_PERIOD = 0.1  # s


class Clock:
    """Publishes simulated time to other nodes and clients."""

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


class ServedTransport(Transport):
    """A transport to which other threads hand calls over.

    Attributes:
        is_ending: True once no further calls are run.
        can_forget: whether `forget` has an effect.
    """

    is_ending = False
    can_forget = False

    def __init__(self) -> None:
        super().__init__()
        self._arrival = threading.Event()  # of an action that was posted

    @abstractmethod
    def post(self, action: Callable[[], None]) -> None:
        """Queues an action for the simulation's thread, between steps.

        Args:
            action: called once, between two steps.
        """

    def _run_posted(self) -> None:
        """Runs the actions that were posted, if they wait for that."""

    def _run_for(self, timeout: float) -> None:
        """Runs the actions that are posted within a real time [s]."""
        deadline = time.monotonic() + timeout
        remaining = timeout
        while remaining > 0.0 and not self.is_ending:
            if self._arrival.wait(remaining):
                self._arrival.clear()
                self._run_posted()
                if self.returns_on_arrival:
                    return
            remaining = deadline - time.monotonic()

    @abstractmethod
    def end_error(self) -> Exception:
        """The error of a call that the end of the simulation leaves without a result."""

    def open_clock(self, timekeeper: Timekeeper) -> Clock:
        """Opens /clock."""
        return Clock(self, timekeeper)

    def call(self, function: Callable[[], T]) -> T:
        """Runs a function on the simulation's thread, between steps, and returns its result.

        Args:
            function: function to call; its exception is raised here.

        Raises:
            Exception: `end_error()`, if the simulation ends before; those of `post`.
        """
        future: Future[T] = Future()

        def run() -> None:
            try:
                future.set_result(function())
            except BaseException as error:
                future.set_exception(error)

        self.post(run)
        return self._result_of(future)

    def wait(self, future: "Future[T]") -> T:
        """Waits for a result that simulated time or a client brings.

        Args:
            future: the result; its exception is raised here.

        Raises:
            Exception: `end_error()`, if the simulation ends before.
        """
        return self._result_of(future)

    def _result_of(self, future: "Future[T]") -> T:
        while not wait([future], _END_CHECK_PERIOD).done:
            if self.is_ending:
                raise self.end_error()
        return future.result()

    def forget(self, publisher: Publisher) -> None:
        """Drops the last message of a latched topic, which later subscribers would get."""

    def registration(self) -> ContextManager[None]:
        """A context in which topics are opened and closed, to register them together."""
        return nullcontext()

    def wait_until_registered(self) -> bool:
        """Waits until clients can find new topics. Returns False if that takes too long."""
        return True
