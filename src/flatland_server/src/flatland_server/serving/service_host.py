"""The interface of what offers services to clients: over ROS, or over other protocols."""

from abc import ABC, abstractmethod
from concurrent.futures import Future
from contextlib import nullcontext
from typing import Any, Callable, ContextManager, Dict, Optional, TypeVar

from flatland_server.exceptions import FlatlandError
from flatland_server.messages.service_types import ServiceType
from flatland_server.serving.client_files import told

T = TypeVar("T")

Action = Callable[[Any], Optional[Dict[str, Any]]]
"""Called with a request, on any thread. Returns fields of the response; `success` is set for it."""


class ServiceError(FlatlandError):
    """A call has failed, and the service's response has no field to say so."""


def answer(service: ServiceType, action: Action, request: Any) -> Any:
    """The response to a request.

    Args:
        service: its type.
        action: its errors are in the response, if that has `success` and `message`.
        request: of the service's type.

    Raises:
        ServiceError: the action has failed, and the response cannot say so.
    """
    has_success = "success" in service.response.__slots__
    try:
        fields = action(request) or {}
    except (FlatlandError, ValueError) as error:
        if not has_success:
            raise ServiceError(told(error)) from None
        return service.response(success=False, message=told(error))
    return service.response(**({"success": True} if has_success else {}), **fields)


class ServiceHost(ABC):
    """Offers services, and runs what they do on the simulation's thread."""

    @abstractmethod
    def offer(self, name: str, type_name: str, action: Action) -> None:
        """Offers a service.

        A FlatlandError or ValueError of the action is reported in the response's `message`, or if
        it has none as a failed call.

        Args:
            name: of the service.
            type_name: such as "flatland_msgs/SpawnModel".
            action: answers a request.
        """

    @abstractmethod
    def call(self, function: Callable[[], T]) -> T:
        """Runs a function on the simulation's thread, between steps, and returns its result.

        Args:
            function: raises what this raises.
        """

    @abstractmethod
    def wait(self, future: "Future[T]") -> T:
        """Waits for a result of the simulation's thread.

        Args:
            future: raises what this raises.
        """

    def registration(self) -> ContextManager[None]:
        """A context in which topics are opened and closed, to register them together."""
        return nullcontext()

    def wait_until_registered(self) -> bool:
        """Waits until clients can find new topics. Returns False if that takes too long."""
        return True

    def world_is_open(self, path: str) -> None:  # noqa: B027 (nothing to do unless it is shown)
        """Tells viewers which world file is open.

        Args:
            path: of the file.
        """
