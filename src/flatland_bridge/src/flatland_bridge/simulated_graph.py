"""The topics and services of a simulation in this process."""

import threading
from functools import partial
from pathlib import Path
from typing import Any, Callable, Dict, FrozenSet, List, Optional, Set, Tuple

from flatland_bridge.budget import Budget
from flatland_bridge.client_messages import require_type
from flatland_bridge.graph import BridgeError, Graph, Receive, Topics
from flatland_bridge.sample import Sample, size_of
from flatland_bridge.shared_transport import SharedTransport
from flatland_bridge.simulation_interfaces import SimulationInterfaces
from flatland_server.config import shipped_worlds
from flatland_server.exceptions import FlatlandError
from flatland_server.geometry import Transform
from flatland_server.hub import ClientFiles, open_hub
from flatland_server.messages import ServiceType, get, stamp_offset
from flatland_server.real_time_timer import RealTimeTimer
from flatland_server.simulation import SimulationManager, World
from flatland_server.transport import Tap, TransformQueue

TFMessage = get("tf2_msgs/TFMessage")

_TOPICS_PERIOD = 0.2
"""Real time between two looks for new topics [s]."""


class SimulatedGraph(Graph, Tap):
    """Shows a simulation: the topics of its plugins, and those and the services of the server.

    A topic without a client counts as one without a subscriber, for which plugins compute nothing.

    Args:
        manager: the simulation; its transport must be a `SharedTransport`.
        state_folder: where clients may save and load states; by default they cannot.
        world_name: under which clients find the first world, besides its path; if any.
        trusts_clients: whether they may name any file, if there is no folder of states.
        hub: further options of `open_hub`.
    """

    def __init__(
        self,
        manager: SimulationManager,
        state_folder: Optional[Path] = None,
        world_name: Optional[str] = None,
        *,
        trusts_clients: bool = False,
        **hub: Any,
    ) -> None:
        assert isinstance(manager.transport, SharedTransport)
        self._transport = manager.transport
        self.parameters = self._transport.parameters
        self._manager = manager
        self._failures = self._transport.failures
        self._receivers: Dict[str, Tuple[Receive, ...]] = {}
        self._open: Set[Tuple[str, Receive]] = set()  # subscriptions that have not ended
        self._lock = threading.Lock()  # with which alone topics come and go there
        self._wanted: FrozenSet[str] = frozenset()  # topics, as the transport knows them
        self._transforms = TransformQueue()
        folder = state_folder
        refused: Tuple[str, ...] = ()
        if state_folder is None and not trusts_clients:
            folder = manager.world.config.model_folders[0]
            refused = ("save_state", "load_state", "save_world")
        files = _WorldsByName(manager.world, folder, world_name)
        self._hub = open_hub(manager, files, refused=refused, **hub)
        SimulationInterfaces(self._hub, files.worlds)
        self._services = {f"/{name}": each for name, each in self._hub.services.items()}
        self._topics_timer = RealTimeTimer(_TOPICS_PERIOD)
        self._follow_topics()
        self._transport.open_tap(self)
        manager.after_step.append(partial(self._failures.catch, self._send_step))
        self._hub.on_tick(self._update)

    # Graph

    @property
    def topics(self) -> Topics:
        return self._topics

    @property
    def services(self) -> Dict[str, ServiceType]:
        return {name: service.type for name, service in self._services.items()}

    @property
    def nanoseconds(self) -> int:
        return self._manager.timekeeper.nanoseconds + stamp_offset()

    def subscribe(
        self, topic: str, receive: Receive, client: Optional[Budget] = None
    ) -> Callable[[], None]:
        key = topic, receive

        def begin() -> None:
            with self._lock:
                if key not in self._open:
                    return
                receivers = self._receivers.get(topic, ())
                if receive not in receivers:
                    self._receivers[topic] = (*receivers, receive)
            self._follow_subscribers()
            last = self._transport.last_latched(topic)
            if last is not None:
                receive(self._sample(topic, last, is_latched=True))

        def end() -> None:
            with self._lock:  # at once: a client may be gone, and the simulation busy
                self._open.discard(key)
                receivers = self._receivers.pop(topic, ())
                rest = tuple(each for each in receivers if each != receive)
                if rest:
                    self._receivers[topic] = rest

        with self._lock:
            self._transport.post(begin, client)
            self._open.add(key)
        return end

    def publish(self, topic: str, message: Any, client: Optional[Budget] = None) -> None:
        require_type(topic, self._transport.types.get(topic), message)
        if topic in self._topics.published:
            raise BridgeError(f'the topic "{topic}" is published by the simulation')
        size = size_of(message)
        if client is not None and not client.offer(size):
            raise BridgeError("the simulation cannot keep up with the client's messages")

        def send() -> None:
            if client is not None:
                client.release(size)
            self._transport.send(topic, message)

        try:
            self._transport.post(send, client)
        except BridgeError:
            if client is not None:
                client.release(size)
            raise

    def call(self, service: str, request: Any) -> Any:
        self.service_type(service)  # it exists
        response = self._services[service].answer(request)
        if getattr(response, "success", True):
            self._transport.call(self._follow_topics)  # so that the client finds new ones at once
            if service == "/seek":
                self._transport.call(self._measure)
        return response

    # Tap: on the simulation's thread

    def wants(self, topic: str) -> bool:
        return topic in self._wanted

    def receive(self, topic: str, message: Any, is_latched: bool) -> None:
        receivers = self._receivers.get(topic)
        if receivers:
            self._failures.catch(self._pass_on, receivers, topic, message, is_latched)

    def receive_transform(self, transform: Transform) -> None:
        self._transforms.add(transform)

    def _send_step(self) -> None:
        """Sends the transforms of a step."""
        data = self._transforms.take()
        if data:
            sample = Sample("/tf", self.nanoseconds, TFMessage, data=data)
            for receive in self._receivers.get("/tf", ()):
                self._failures.catch(receive, sample)

    def _update(self) -> None:
        if self._topics_timer.check_update():
            self._follow_subscribers()
            self._follow_topics()

    def _measure(self) -> None:
        """Publishes what sensors measure now, without a step."""
        for topic in self._wanted & set(self._transport.topics):
            plugins = self._manager.world.contents.plugins
            plugins.publish_now(topic, self._manager.timekeeper)

    def _follow_subscribers(self) -> None:
        """Tells plugins which topics have subscribers."""
        with self._lock:
            wanted = frozenset(self._receivers)
        if wanted != self._wanted:
            self._wanted = wanted
            self._transport.set_subscribed_topics(wanted)

    def _follow_topics(self) -> None:
        transport = self._transport
        types = {**transport.types, "/tf": TFMessage._type}
        published = sorted({*transport.topics, "/tf"})
        self._topics = Topics(
            {name: types[name] for name in published},
            {name: types[name] for name in sorted(transport.subscribed) if name in types},
            frozenset(transport.latched),
        )

    def _pass_on(
        self, receivers: Tuple[Receive, ...], topic: str, message: Any, is_latched: bool
    ) -> None:
        sample = self._sample(topic, message, is_latched=is_latched)
        for receive in receivers:
            self._failures.catch(receive, sample)

    def _sample(self, topic: str, message: Any, *, is_latched: bool) -> Sample:
        message_type = get(message._type)
        return Sample(topic, self.nanoseconds, message_type, message, is_latched=is_latched)


class _WorldsByName(ClientFiles):
    """Clients name shipped worlds, that of the beginning, and files in the folders of the world.

    A world that they save may have a relative path, which begins in the folder of states.

    Args:
        world: the simulated world.
        state_folder: as for `ClientFiles`.
        name: name of the present world besides its path; empty for none.
    """

    def __init__(self, world: World, state_folder: Optional[Path], name: Optional[str]) -> None:
        super().__init__(world, state_folder)
        self._folder = Path() if state_folder is None else state_folder.absolute()
        path = world.config.path
        self._first = {} if path is None else {str(path.absolute()): path, str(path): path}
        if path is not None and name is not None:
            self._first[name] = path

    def worlds(self) -> List[Path]:
        """The worlds that clients can open by name."""
        return list(dict.fromkeys([*self._first.values(), *shipped_worlds().values()]))

    def world_file(self, name: str) -> Path:
        worlds = {**shipped_worlds(), **self._first}
        return worlds.get(name) or super().world_file(name)

    def written_world(self, name: str) -> Path:
        if not name and self._world.config.path in shipped_worlds().values():
            raise FlatlandError("the world is one of Flatland's own; save a copy of it")
        return super().written_world(str(self._folder / name) if name else name)
