"""Time of a step by part: python -m flatland_benchmark.step_parts WORLD.

The world runs in this process, without a master. With `--subscribed`, all topics and markers count
as subscribed to: messages are made and serialised as rospy does, and dropped. Prints the time of
each part in microseconds as JSON.
"""

import argparse
import json
import sys
import time
from collections import defaultdict
from contextlib import contextmanager
from io import BytesIO
from pathlib import Path
from statistics import median
from typing import Any, Callable, DefaultDict, Dict, Iterator, List, Optional, Sequence, Tuple

from flatland_server import _core
from flatland_server.geometry import Transform
from flatland_server.messages.model_markers import ModelMarkers
from flatland_server.messages.serialized_markers import array_of
from flatland_server.simulation.run import Run
from flatland_server.simulation.world import World
from flatland_server.timekeeper import Timekeeper
from flatland_server.transport.local_transport import LocalTransport
from flatland_server.transport.message_writer import MessageWriter
from flatland_server.transport.node import Frames, Publisher
from flatland_server.transport.serialized_transforms import SerializedFrames, TransformQueue

PARTS = ("physics", "scans", "plugins", "publishing", "markers")

_STEP_SIZE = 0.005
_BLOCK = 20
"""Steps per block, one scan period; the result is the median over blocks."""
_MARKER_PERIOD = 200 / 30
"""Steps between publications of markers: 30 Hz at 200 steps per second, as in the server."""


class Stopwatch:
    """Exclusive times of nested parts of a program."""

    def __init__(self) -> None:
        self.seconds: DefaultDict[str, float] = defaultdict(float)
        self._parts: List[str] = []  # the outermost first
        self._since = 0.0

    def timed(self, part: str, function: Callable[..., Any]) -> Callable[..., Any]:
        """Wraps a function so that its time counts for a part."""

        def measured(*arguments: Any, **options: Any) -> Any:
            self._note()
            self._parts.append(part)
            try:
                return function(*arguments, **options)
            finally:
                self._note()
                self._parts.pop()

        return measured

    def _note(self) -> None:
        """Adds the time since the last call to the innermost part."""
        now = time.perf_counter()
        if self._parts:
            self.seconds[self._parts[-1]] += now - self._since
        self._since = now


class Serializing(LocalTransport):
    """Serialises messages of topics with subscribers, and drops them."""

    def __init__(self, is_subscribed: bool) -> None:
        super().__init__(subscribed_topics=None if is_subscribed else ())
        self._transforms = TransformQueue()

    def advertise(
        self, topic: str, message_type: Any, *, latch: bool, queue_size: int
    ) -> Publisher:
        return _SerializingPublisher(self, topic)

    def send_transform(self, transform: Transform) -> None:
        self._transforms.add(transform)

    def open_frames(self, names: Sequence[Tuple[str, str]]) -> Frames:
        return SerializedFrames(self._transforms, names)

    def flush(self) -> None:
        self._transforms.take()

    def send_bytes(self, message: Any) -> None:
        """Serialises a message, as rospy does before it writes to a socket."""
        message.serialize(BytesIO())

    def write(self, writer: MessageWriter, *values: Any) -> None:
        """Serialises values directly."""
        writer.data(*values)


class _SerializingPublisher(Publisher):
    def __init__(self, transport: Serializing, topic: str) -> None:
        self._transport = transport
        self._topic = topic

    @property
    def has_subscribers(self) -> bool:
        return self._transport.has_subscribers(self._topic)

    def publish(self, message: Any) -> None:
        if self.has_subscribers:
            self._transport.send_bytes(message)

    def write(self, writer: MessageWriter, *values: Any) -> None:
        if self.has_subscribers:
            self._transport.write(writer, *values)

    def close(self) -> None:
        pass


class _Run:
    """A world that is stepped, with its markers."""

    def __init__(self, path: Path, is_subscribed: bool) -> None:
        self.transport = Serializing(is_subscribed)
        world = World.from_file(path, self.transport)
        self._run = Run(world, Timekeeper(_STEP_SIZE))
        self._markers = [ModelMarkers(model, "map") for model in world.models.values()]
        self._is_subscribed = is_subscribed

    def step(self) -> None:
        self._run.step()

    def publish_markers(self) -> None:
        for markers in self._markers:
            markers.place()
        self.transport.send_bytes(array_of([markers.bytes() for markers in self._markers]))

    def block(self) -> float:
        """Runs a block of steps; returns its duration [s]."""
        published = 0
        begin = time.perf_counter()
        for count in range(_BLOCK):
            self.step()
            if self._is_subscribed and count >= published * _MARKER_PERIOD:
                self.publish_markers()
                published += 1
        return time.perf_counter() - begin


def measure(path: Path, is_subscribed: bool, steps: int) -> Dict[str, float]:
    """Time of a step [s], in total and by part.

    Args:
        path: the world file.
        is_subscribed: whether all topics have a subscriber.
        steps: number of measured steps, rounded to whole blocks.
    """
    plain = _Run(path, is_subscribed)
    plain.block()  # includes one-time work
    whole = [plain.block() for _ in range(max(1, steps // _BLOCK))]
    stopwatch = Stopwatch()
    run = _timed_run(path, is_subscribed, stopwatch)
    parts: Dict[str, List[float]] = {part: [] for part in PARTS}
    with _timed_scans(stopwatch):
        run.block()
        for _ in whole:
            stopwatch.seconds.clear()
            run.block()
            for part in PARTS:
                parts[part].append(stopwatch.seconds[part])
    return {name: median(times) / _BLOCK for name, times in {"step": whole, **parts}.items()}


def _timed_run(path: Path, is_subscribed: bool, stopwatch: Stopwatch) -> _Run:
    original = _core.World
    _core.World = _timed_physics(stopwatch)
    try:
        run = _Run(path, is_subscribed)
    finally:
        _core.World = original
    transport = run.transport
    for name in ("send_bytes", "write", "flush", "process"):
        setattr(transport, name, stopwatch.timed("publishing", getattr(transport, name)))
    run.step = stopwatch.timed("plugins", run.step)  # all time outside the other parts
    run.publish_markers = stopwatch.timed("markers", run.publish_markers)
    return run


def _timed_physics(stopwatch: Stopwatch) -> type:
    """The physical world, with its steps measured."""
    methods = {"step": stopwatch.timed("physics", _core.World.step)}
    return type("TimedWorld", (_core.World,), methods)


@contextmanager
def _timed_scans(stopwatch: Stopwatch) -> Iterator[None]:
    """Measures the scans of all lidars."""
    original = _core.Lidar.scan
    _core.Lidar.scan = stopwatch.timed("scans", original)
    try:
        yield
    finally:
        _core.Lidar.scan = original


def main(arguments: Optional[List[str]] = None) -> int:
    """Prints the times. Returns the exit code."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("world", type=Path)
    parser.add_argument("--subscribed", action="store_true", help="with a subscriber to all topics")
    parser.add_argument("--steps", type=int, default=1000)
    options = parser.parse_args(arguments)
    seconds = measure(options.world, options.subscribed, options.steps)
    print(json.dumps({part: value * 1e6 for part, value in seconds.items()}))
    return 0


if __name__ == "__main__":
    sys.exit(main())
