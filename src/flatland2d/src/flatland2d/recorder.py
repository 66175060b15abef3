"""Records the topics of a world in this process into a file, for rosbag, rviz or Foxglove.

with Recorder(transport, timekeeper, "run.bag", topics=["/scan", "/odom"]) as recorder:
    for _ in range(200):
        manager.step()
        recorder.write_step()
"""

import os
import re
import struct
from functools import partial
from typing import (
    TYPE_CHECKING,
    Any,
    Callable,
    Collection,
    Dict,
    Iterable,
    List,
    NamedTuple,
    Optional,
    Pattern,
    Tuple,
    Union,
)

from flatland2d.recording_file import RecordingFile
from flatland2d.recording_format import Channel
from flatland_server.arguments import several
from flatland_server.config import is_topic
from flatland_server.exceptions import MessageError, RecordingError, shortened
from flatland_server.geometry import Transform
from flatland_server.hub import MapToOdom
from flatland_server.messages import get, serialized
from flatland_server.timekeeper import Timekeeper
from flatland_server.transport import LocalTransport, OdometryFrame, Tap, TransformQueue

if TYPE_CHECKING:
    from flatland2d.ros2_messages import Ros2Messages

_ALWAYS = ("/clock", "/tf", "/tf_static")
_TICK = struct.Struct("<2I")
_SEQUENCE = struct.Struct("<I")


class _Message(NamedTuple):
    """A message that waits for the end of its step."""

    nanoseconds: int
    topic: str
    content: Any  # a message or a TransformQueue
    is_latched: bool


class Recorder(Tap):
    """Records messages with the simulated time at which they were published or sent.

    The times of the steps and the transforms are always recorded, as `/clock` and `/tf`, and the
    identity from `map` to the frames of odometry on `/tf_static`: without them, rviz could not show
    the other topics. As with `rosbag record`, a recorded topic counts as subscribed to.

    When time goes back, as by a reset, a further file begins: run.bag, run_1.bag, run_2.bag. So the
    times of a file never go back, and no file has two runs.

    Args:
        transport: transport with the topics to record.
        timekeeper: gives the simulated time of each message.
        path: of the file, which ends with .bag or .mcap. It has ".active" appended until it is
            closed; then it replaces a recording of the same name.
        topics: names of topics, or regular expressions that match whole names; by default all.
        odometry_frames: returns the present frames of odometry: `lambda: world.odometry_frames`.
        ros2: whether to record messages as ROS 2 has them, into an .mcap.

    Raises:
        MissingPackageError: messages of ROS 2 need rosbags.
        RecordingError: the file cannot be written, something else than a recording is there, or a
            topic is neither a name nor a regular expression.
        UsageError: `topics` is no list.
    """

    def __init__(
        self,
        transport: LocalTransport,
        timekeeper: Timekeeper,
        path: Union[str, "os.PathLike[str]"],
        topics: Optional[Iterable[str]] = None,
        odometry_frames: Callable[[], Collection[OdometryFrame]] = frozenset,
        ros2: bool = False,
    ) -> None:
        self._transport = transport
        self._timekeeper = timekeeper
        self._patterns = None if topics is None or topics == "all" else _compiled(topics)
        self._wanted: Dict[str, bool] = {}
        self._channels: Dict[Tuple[str, Any, bool], Channel] = {}
        self._waiting: List[_Message] = []
        self._transforms: Dict[int, TransformQueue] = {}  # the waiting ones, by their time
        self._sequences: Dict[str, int] = {}
        self._clock_type = get("rosgraph_msgs/Clock")
        self._transforms_type = get("tf2_msgs/TFMessage")
        self._ros2 = _ros2_messages() if ros2 else None
        self._is_open = True
        self._open_file = partial(RecordingFile, encoding="cdr" if ros2 else "ros1")
        self._file = self._open_file(path)
        self._path = self._file.path
        self._files = 1
        self._time = 0  # of the last step [ns]
        self._map_to_odom = MapToOdom(transport, odometry_frames, always=())
        transport.open_tap(self)
        try:
            self.write_step()
        except BaseException:
            self.close()
            raise

    @property
    def is_open(self) -> bool:
        """True if the recording goes on: until `close`, or the disk is full."""
        return self._is_open

    def wants(self, topic: str) -> bool:
        wanted = self._wanted.get(topic)
        if wanted is None:
            wanted = self._wanted[topic] = (
                self._patterns is None
                or topic in _ALWAYS
                or any(pattern.fullmatch(topic) for pattern in self._patterns)
            )
        return wanted

    def unmatched(self, names: Collection[str]) -> List[str]:
        """The topics to record that do not exist.

        Args:
            names: names of the topics that exist.
        """
        known = {*names, *_ALWAYS}
        return [
            pattern.pattern
            for pattern in self._patterns or ()
            if not any(map(pattern.fullmatch, known))
        ]

    def receive(self, topic: str, message: Any, is_latched: bool) -> None:
        now = self._timekeeper.nanoseconds
        self._waiting.append(_Message(now, topic, message, is_latched))

    def receive_transform(self, transform: Transform) -> None:
        now = self._timekeeper.nanoseconds
        if now not in self._transforms:  # all transforms of one time are one message
            self._transforms[now] = TransformQueue()
            self._waiting.append(_Message(now, "/tf", self._transforms[now], False))
        self._transforms[now].add(transform)

    def write_step(self) -> None:
        """Writes the messages since the last call, and the time; call it after each step.

        Raises:
            MessageError: a published object is no message, or has a wrong value.
            RecordingError: the file cannot be written, or is closed. On a full disk, the recording
                ends with what there is room for.
        """
        if not self._is_open:
            raise RecordingError(f"{self._file.path}: the recording is closed")
        try:
            self._write_waiting()
        except RecordingError:
            self._waiting = []
            self.close()
            raise

    def close(self) -> None:
        """Finishes the file. Messages since the last `write_step` are written."""
        if not self._is_open:
            return
        self._is_open = False
        self._transport.close_tap(self)
        self._map_to_odom.close()
        try:
            for each in self._waiting:
                self._write(each)
        finally:
            self._file.close()

    def __enter__(self) -> "Recorder":
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def _write_waiting(self) -> None:
        self._map_to_odom.publish_new()
        now = self._timekeeper.nanoseconds
        if now < self._time:
            self._begin_file(now)
        self._time = now
        waiting, self._waiting = self._waiting, []
        self._transforms.clear()
        # A time comes before its messages, in the order in which the server sends them.
        for each in waiting:
            if each.nanoseconds < now:
                self._write(each)
        self._write_data("/clock", self._clock_type, now, _TICK.pack(*divmod(now, 1_000_000_000)))
        for each in waiting:
            if each.nanoseconds >= now:
                self._write(each)

    def _begin_file(self, now: int) -> None:
        """Goes on in a further file, which begins with the last latched messages."""
        path = self._path.with_name(f"{self._path.stem}_{self._files}{self._path.suffix}")
        file = self._open_file(path)
        self._files += 1
        waiting, self._waiting = self._waiting, []
        for each in waiting:
            if each.nanoseconds > now:
                self._write(each)
            elif not each.is_latched:
                self._waiting.append(each)
        self._file.close()
        self._file = file
        self._channels.clear()
        self._sequences.clear()
        self._transport.close_tap(self)
        self._transport.open_tap(self)

    def _write(self, each: _Message) -> None:
        if isinstance(each.content, TransformQueue):
            self._write_data(
                each.topic, self._transforms_type, each.nanoseconds, each.content.take()
            )
            return
        kind = type(each.content)
        if not hasattr(kind, "_md5sum"):
            found = shortened(repr(each.content))
            raise MessageError(f'expected a message on the topic "{each.topic}", found {found}')
        data = self._numbered(each.topic, kind, serialized(each.content))
        self._write_data(each.topic, kind, each.nanoseconds, data, each.is_latched)

    def _write_data(
        self, topic: str, kind: Any, nanoseconds: int, data: bytes, is_latched: bool = False
    ) -> None:
        key = (topic, kind, is_latched)
        channel = self._channels.get(key)
        if channel is None:
            channel = self._channels[key] = self._channel(topic, kind, is_latched)
        if self._ros2 is not None:
            data = self._ros2.type_of(kind).to_cdr(data)
        self._file.write(channel, nanoseconds, data)

    def _channel(self, topic: str, kind: Any, is_latched: bool) -> Channel:
        if self._ros2 is None:
            return Channel(topic, kind._type, kind._md5sum, kind._full_text, is_latched)
        name, definition, checksum, *_ = self._ros2.type_of(kind)
        return Channel(topic, name, checksum, definition, is_latched, "cdr")

    def _numbered(self, topic: str, kind: Any, data: bytes) -> bytes:
        """A serialized message with the number that rospy gives it, the first of its header."""
        if not kind._has_header:
            return data
        number = self._sequences[topic] = self._sequences.get(topic, 0) + 1
        return _SEQUENCE.pack(number) + data[_SEQUENCE.size :]


def _ros2_messages() -> "Ros2Messages":
    from flatland2d.ros2_messages import Ros2Messages  # a third of a second of imports

    return Ros2Messages()


def _compiled(topics: Iterable[str]) -> List[Pattern[str]]:
    patterns = []
    for topic in [topics] if isinstance(topics, str) else several(topics, "topics"):
        try:
            patterns.append(re.compile(f"/{topic}" if _is_relative(topic) else topic))
        except (re.error, TypeError):
            raise RecordingError(
                "expected the name of a topic, or a regular expression that matches names, "
                f"found {shortened(repr(topic))}"
            ) from None
    return patterns


def _is_relative(topic: str) -> bool:
    return isinstance(topic, str) and is_topic(topic) and not topic.startswith("/")
