"""Calls of other threads that run on the simulation's thread."""

from abc import ABC, abstractmethod
from concurrent.futures import Future, wait
from typing import Callable, TypeVar

T = TypeVar("T")

_END_CHECK_PERIOD = 0.1  # s


class ThreadCalls(ABC):
    """A transport to which other threads hand calls over.

    Attributes:
        is_ending: True once no further calls are run.
    """

    is_ending = False

    @abstractmethod
    def post(self, action: Callable[[], None]) -> None:
        """Queues an action for the simulation's thread, between steps.

        Args:
            action: called between two steps.
        """

    @abstractmethod
    def end_error(self) -> Exception:
        """The error of a call that the end of the simulation leaves without a result."""

    def call(self, function: Callable[[], T]) -> T:
        """Runs a function on the simulation's thread, between steps, and returns its result.

        Args:
            function: raises what this raises.

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
        return self.wait(future)

    def wait(self, future: "Future[T]") -> T:
        """Waits for a result of the simulation's thread.

        Args:
            future: raises what this raises.

        Raises:
            Exception: `end_error()`, if the simulation ends before.
        """
        while not wait([future], _END_CHECK_PERIOD).done:
            if self.is_ending:
                raise self.end_error()
        return future.result()
