"""A served simulation, as its services and its protocols see it.

`assembly.open_hub` puts one together. A protocol then calls `Service.answer` on threads of its own.
"""

import logging
from functools import partial
from typing import Any, Callable, Dict, List, NamedTuple, Optional, Set, Tuple, TypeVar, Union

from flatland_server.exceptions import FlatlandError
from flatland_server.hub.client_edits import ClientEdits
from flatland_server.hub.client_files import ClientFiles, told
from flatland_server.hub.map_to_odom import MapToOdom
from flatland_server.messages.message_types import get
from flatland_server.messages.service_types import ServiceType
from flatland_server.messages.service_types import get as get_service
from flatland_server.simulation.simulation_manager import SimulationManager
from flatland_server.transport.served_transport import ServedTransport

logger = logging.getLogger(__name__)

T = TypeVar("T")

Action = Callable[[Any], Optional[Dict[str, Any]]]
"""Called with a request, on any thread. Returns fields of the response; `success` is set for it."""


class ServiceError(FlatlandError):
    """A call has failed, and the service's response has no field to say so."""


class Service(NamedTuple):
    """A service of the simulation."""

    type: ServiceType
    action: Action

    def answer(self, request: Any) -> Any:
        """The response to a request; for any thread.

        Raises:
            ServiceError: the action has failed, and the response has no `success` and `message`.
        """
        response = self.type.response
        has_success = "success" in response.__slots__
        try:
            fields = self.action(request) or {}
        except (FlatlandError, ValueError) as error:
            if not has_success:
                raise ServiceError(told(error)) from None
            return response(success=False, message=told(error))
        return response(**({"success": True} if has_success else {}), **fields)


class Failures:
    """Keeps errors from ending the simulation. Each kind is logged once."""

    def __init__(self) -> None:
        self._kinds: Set[Tuple[str, str]] = set()

    def catch(self, function: Callable[..., object], *arguments: Any) -> None:
        """Calls a function.

        Args:
            function: function to call; it may raise any exception.
            arguments: arguments of the call.
        """
        try:
            function(*arguments)
        except Exception as error:
            name = getattr(function, "__qualname__", repr(type(function)))
            kind = name, type(error).__name__
            if kind not in self._kinds:
                self._kinds.add(kind)
                logger.exception("%s has failed; the simulation goes on", name)


class Hub:
    """Services and topics that clients of all protocols share.

    Args:
        manager: the simulation; its transport must be a `ServedTransport`.
        files: finds the files that clients name.
        refused: names of services that are not offered.

    Attributes:
        manager: the simulation.
        world: the simulation's world.
        transport: carries the topics, and hands calls over to the simulation's thread.
        files: finds the files that clients name.
        edits: what clients have changed.
        map_to_odom: stands in for a localiser, if anything does.
        services: by name, without "/".
        failures: of what is called for clients.
        on_open: called with the path of a world file that a client has opened or saved.
    """

    def __init__(
        self, manager: SimulationManager, files: ClientFiles, refused: Tuple[str, ...] = ()
    ) -> None:
        assert isinstance(manager.transport, ServedTransport)
        self.manager = manager
        self.world = manager.world
        self.transport: ServedTransport = manager.transport
        self.files = files
        self.edits = ClientEdits(manager.world)
        self.failures = Failures()
        self.map_to_odom: Optional[MapToOdom] = None
        self.services: Dict[str, Service] = {}
        self.on_open: List[Callable[[str], None]] = []
        self._refused = refused

    def on_tick(self, action: Callable[[], None]) -> None:
        """Calls an action before each wait for the next step, also during a pause.

        Args:
            action: an error of it does not end the simulation.
        """
        self.manager.on_tick.append(partial(self.failures.catch, action))

    def offer(self, name: str, kind: Union[str, ServiceType], action: Action) -> None:
        """Offers a service.

        A FlatlandError or ValueError of the action is reported in the response's `message`, or if
        it has none as a failed call.

        Args:
            name: the service's name.
            kind: its type, or the name of that, such as "flatland_msgs/SpawnModel".
            action: answers a request. It reads files on its own thread, and changes the simulation
                by `transport.call`.
        """
        if name not in self._refused:
            service_type = get_service(kind) if isinstance(kind, str) else kind
            self.services[name] = Service(service_type, action)

    def call(self, name: str, /, **fields: Any) -> None:
        """Calls a service, on this thread; its response is left out.

        Args:
            name: the service's name.
            fields: of the request.

        Raises:
            FlatlandError: it fails.
            ValueError: it fails.
        """
        service = self.services[name]
        service.action(service.type.request(**fields))

    def change(self, action: Callable[[], T]) -> T:
        """Changes the world on the simulation's thread, between two steps; returns the result.

        Clients can use its new topics then.

        Args:
            action: opens and closes topics, which are registered together.
        """

        def change() -> T:
            with self.transport.registration():
                return action()

        result = self.transport.call(change)
        self.transport.wait_until_registered()
        return result

    def obey(self, topic: str, kind: str, action: Callable[[Any], None]) -> None:
        """Subscribes to a topic of requests. An error is a warning, once for equal ones in a row.

        Args:
            topic: such as "move_model".
            kind: the message type, such as "flatland_msgs/MoveModelMsg".
            action: called with each message, between two steps.
        """
        name = self.transport.resolve(topic)
        last_warning = ""

        def receive(message: Any) -> None:
            nonlocal last_warning
            warning = ""
            try:
                action(message)
            except (FlatlandError, ValueError) as error:
                warning = told(error)
                if warning != last_warning:
                    logger.warning("%s: %s", name, warning)
            last_warning = warning

        self.transport.subscribe(topic, get(kind), receive)
