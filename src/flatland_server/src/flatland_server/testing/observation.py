"""Observes a plugin in a world: the keys that it reads, and all that it publishes."""

import gc
from contextlib import ExitStack, contextmanager
from typing import (
    Any,
    Callable,
    Collection,
    Dict,
    Iterator,
    List,
    NamedTuple,
    Optional,
    Set,
    Tuple,
    Type,
    TypeVar,
)
from unittest import mock
from weakref import ref

from flatland_server.config.yaml_reader import YamlReader
from flatland_server.geometry import Transform
from flatland_server.messages.wire_form import serialized
from flatland_server.plugins.plugin import Plugin
from flatland_server.plugins.plugin_loader import PluginLoader
from flatland_server.timekeeper import Timekeeper
from flatland_server.transport.local_transport import LocalTransport
from flatland_server.transport.transport import MessageWriter, Publisher, Subscription

P = TypeVar("P", bound=Plugin)


class Event(NamedTuple):
    """A message, and when it was published."""

    step: int
    nanoseconds: int
    topic: str
    message: Any

    @property
    def data(self) -> bytes:
        """The message's content, for comparison."""
        return content_of(self.message)


def content_of(message: Any) -> bytes:
    """A message as bytes; for an object that is no ROS message, its description."""
    return serialized(message) if hasattr(message, "serialize") else repr(message).encode()


class ObservingTransport(LocalTransport):
    """Keeps everything that is published.

    Args:
        subscribed_topics: the topics that have a subscriber; all of them if None.
    """

    def __init__(self, subscribed_topics: Optional[Collection[str]] = None) -> None:
        super().__init__(subscribed_topics=subscribed_topics)
        self.step = 1
        """The number of the step that is being made, or comes next."""
        self.timekeeper: Optional[Timekeeper] = None
        self.events: List[Event] = []
        self.sent_transforms: List[Tuple[int, int, Transform]] = []
        """The step, the time [ns] and the transform."""
        self.types: Dict[str, Any] = {}
        """The message type of each topic that was ever published or subscribed to."""
        self.latched: Set[str] = set()
        self.wrong_data: List[str] = []
        """The topics with a `MessageWriter` that makes other bytes than those of its message."""

    @property
    def now(self) -> int:
        """The simulated time [ns]: that before or after a step, as the hook has it."""
        return self.timekeeper.nanoseconds if self.timekeeper is not None else 0

    def advertise(
        self, topic: str, message_type: Any, *, latch: bool, queue_size: int
    ) -> Publisher:
        topic = f"/{topic.lstrip('/')}"
        self.types[topic] = message_type
        if latch:
            self.latched.add(topic)
        publisher = super().advertise(topic, message_type, latch=latch, queue_size=queue_size)
        return _ObservingPublisher(self, topic, publisher)

    def subscribe(
        self, topic: str, message_type: Any, callback: Callable[[Any], None]
    ) -> Subscription:
        topic = f"/{topic.lstrip('/')}"
        self.types[topic] = message_type
        return super().subscribe(topic, message_type, callback)

    def send_transform(self, transform: Transform) -> None:
        self.sent_transforms.append((self.step, self.now, transform))
        super().send_transform(transform)

    def count_step(self) -> None:
        """Counts a step; must be called after each."""
        self.step += 1

    @contextmanager
    def counting_messages(self) -> Iterator[Dict[str, int]]:
        """Counts the messages that are made meanwhile, by topic, published or not."""
        counts: Dict[str, int] = {}
        with ExitStack() as stack:
            for topic in self.topics - self.latched:
                stack.enter_context(_counting(self.types[topic], topic, counts))
            yield counts


@contextmanager
def _counting(message_type: Any, topic: str, counts: Dict[str, int]) -> Iterator[None]:
    original = message_type.__init__

    def init(self: Any, *args: Any, **fields: Any) -> None:
        counts[topic] = counts.get(topic, 0) + 1
        original(self, *args, **fields)

    with mock.patch.object(message_type, "__init__", init):
        yield


class _ObservingPublisher(Publisher):
    def __init__(self, transport: ObservingTransport, topic: str, publisher: Publisher) -> None:
        self._transport = transport
        self._topic = topic
        self._publisher = publisher

    @property
    def has_subscribers(self) -> bool:
        return self._publisher.has_subscribers

    def publish(self, message: Any) -> None:
        transport = self._transport
        event = Event(transport.step, transport.now, self._topic, message)
        transport.events.append(event)
        self._publisher.publish(message)

    def write(self, writer: MessageWriter, *values: Any) -> None:
        if not _is_same(writer.data(*values), writer.message(*values)):
            self._transport.wrong_data.append(self._topic)
        super().write(writer, *values)

    def close(self) -> None:
        self._publisher.close()


def _is_same(data: bytes, message: Any) -> bool:
    """True if bytes equal a serialized message, except for the sequence number of its header."""
    received = type(message)().deserialize(data)
    if hasattr(received, "header"):
        received.header.seq = message.header.seq
    return content_of(received) == content_of(message)


class ObservingLoader(PluginLoader):
    """Loads plugins of one type as subclasses that note which keys they read.

    Args:
        loader: finds the classes.
        type: which plugins are observed.
    """

    def __init__(self, loader: PluginLoader, type: str) -> None:
        super().__init__([])
        self._loader = loader
        self._type = type
        self.keys: Set[str] = set()
        """The keys that were read, such as "range", "angle.min" or, of lists, "people.pose"."""
        self.plugins: List[ref[Plugin]] = []
        """The plugins that were made."""

    def load(self, type: str, base: Type[P]) -> Type[P]:
        plugin_class = self._loader.load(type, base)
        if type != self._type:
            return plugin_class
        loader = self

        class Observed(plugin_class):  # type: ignore[valid-type, misc]
            def on_initialize(self, config: Any) -> None:
                loader.plugins.append(ref(self))
                super().on_initialize(_ObservingReader(config, loader.keys))

        Observed.__name__ = plugin_class.__name__
        Observed.__qualname__ = plugin_class.__qualname__
        return Observed

    def living_plugins(self) -> int:
        """The number of the plugins that are still referred to."""
        gc.collect()
        return sum(plugin() is not None for plugin in self.plugins)


class _ObservingReader:
    """A `YamlReader` that notes the keys it is asked for; everything is done by the real one."""

    def __init__(self, reader: YamlReader, keys: Set[str], path: str = "") -> None:
        self._reader = reader
        self._keys = keys
        self._path = path

    def __getattr__(self, name: str) -> Any:
        attribute = getattr(self._reader, name)
        if not name.startswith("get_"):
            return attribute

        def get(key: str, *args: Any, **options: Any) -> Any:
            self._keys.add(f"{self._path}{key}")
            value = attribute(key, *args, **options)
            return self._within(key, value) if name == "get_section" else value

        return get

    def get_sections(self, key: str, read: Callable[[Any], Any], **options: Any) -> List[Any]:
        """As that of a `YamlReader`, with observed readers of the entries."""
        self._keys.add(f"{self._path}{key}")
        return self._reader.get_sections(
            key, lambda reader: read(self._within(key, reader)), **options
        )

    def _within(self, key: str, reader: YamlReader) -> "_ObservingReader":
        return _ObservingReader(reader, self._keys, f"{self._path}{key}.")
