"""Cases of `flatland serve`: the highest rate at which a client of a protocol gets every message.

The client is a loop over frames that counts them by topic and reads the stamps of the first and the
last: a program that decodes each message would be slower than the server.
"""

import json
import os
import struct
import sys
import tempfile
import time
from pathlib import Path
from typing import Any, Dict, List, Optional, Tuple

from flatland_benchmark.case import Figures, case
from flatland_benchmark.highest_rate import MEASURING, highest_rate
from flatland_benchmark.process import Process, wait_until
from flatland_benchmark.robot_worlds import write_world
from flatland_server.testing.ports import free_port

_ROBOTS = (1, 10)
_SETTLING = 1.0  # s
_PERIODS = {"scan": 0.1, "odometry/filtered": 0.005}
"""Of the topics of each robot [s of simulated time]."""


class _Client:
    """A WebSocket to `flatland serve`, which calls services by rosbridge's protocol."""

    def __init__(self, port: int, subprotocols: Optional[List[Any]] = None) -> None:
        from websockets.sync.client import connect

        self.socket = connect(f"ws://127.0.0.1:{port}", subprotocols=subprotocols, max_size=None)

    def send(self, **message: object) -> None:
        self.socket.send(json.dumps(message))

    def change_rate(self, rate: float) -> None:
        self.send(op="call_service", service="/change_rate", args={"rate": min(rate, 1e9)})
        json.loads(self.socket.recv())


class _Topic:
    """The frames of a topic.

    Attributes:
        first: the first one.
        last: the last one.
        count: their number.
    """

    def __init__(self, frame: bytes) -> None:
        self.first = self.last = frame
        self.count = 1


def _received(viewer: Any, seconds: float) -> List[_Topic]:
    """The messages of some real time, by topic."""
    topics: Dict[bytes, _Topic] = {}
    kind, head = viewer.kind, viewer.head
    receive, end = viewer.client.socket.recv, time.monotonic() + seconds
    while time.monotonic() < end:
        frame = receive()
        if isinstance(frame, bytes) and frame[0] == kind:
            topic = topics.get(frame[head])
            if topic is None:
                topics[frame[head]] = _Topic(frame)
            else:
                topic.last = frame
                topic.count += 1
    return list(topics.values())


class _Cbor:
    """A client of rosbridge with CBOR.

    Attributes:
        kind: the first byte of a message's frame.
        head: the part of it that tells the topic.
    """

    kind = 0xA3  # a map of three: op, topic, msg

    def __init__(self, rosbridge_port: int, foxglove_port: int, topics: List[str]) -> None:
        import cbor2

        self._loads = cbor2.loads
        self._topics = topics
        self.client = _Client(rosbridge_port)
        for topic in topics:
            self.client.send(op="subscribe", topic=topic, compression="cbor")
        self.head = slice(0, 20 + max(map(len, topics)))

    def stamp(self, frame: bytes) -> Tuple[str, float]:
        """The topic and the stamp of a frame [s]."""
        message = self._loads(frame)
        stamp = message["msg"]["header"]["stamp"]
        return message["topic"], stamp["secs"] + stamp["nsecs"] * 1e-9


class _Foxglove:
    """A client of the Foxglove WebSocket protocol; attributes as of `_Cbor`."""

    kind = 1
    head = slice(1, 5)

    def __init__(self, rosbridge_port: int, foxglove_port: int, topics: List[str]) -> None:
        self._topics = topics
        self.client = _Client(foxglove_port, ["foxglove.websocket.v1"])
        channels: Dict[str, int] = {}
        while not channels.keys() >= {*topics}:
            message = json.loads(self.client.socket.recv())
            channels.update({each["topic"]: each["id"] for each in message.get("channels", ())})
        wanted = [{"id": i, "channelId": channels[topic]} for i, topic in enumerate(topics)]
        self.client.send(op="subscribe", subscriptions=wanted)

    def stamp(self, frame: bytes) -> Tuple[str, float]:
        """The topic and the stamp of a frame [s]."""
        _, number, nanoseconds = struct.unpack_from("<BIQ", frame)
        return self._topics[number], nanoseconds * 1e-9


_PROTOCOLS: Dict[str, Any] = {"cbor": _Cbor, "foxglove": _Foxglove}


@case(
    "serve_{robots}_all_{protocol}",
    "the same of flatland serve",
    robots=_ROBOTS,
    protocol=tuple(_PROTOCOLS),
)
def serve_all(worlds: Path, robots: int, protocol: str) -> Figures:
    """One client that subscribes to all robots' scans and odometry."""
    ports = free_port(), free_port()
    names = [f"/robot_{i}/{topic}" for i in range(robots) for topic in _PERIODS]
    with tempfile.TemporaryDirectory(prefix="flatland_benchmark_") as folder:
        world = write_world(Path(folder), worlds, robots)
        command = [sys.executable, "-m", "flatland2d", "serve", str(world)]
        command += ["--port", str(ports[0]), "--foxglove-port", str(ports[1])]
        server = Process("flatland_serve", command, Path(folder), dict(os.environ))
        try:
            wait_until(lambda: "ws://" in server.output, "its addresses", [server])
            controller = _Client(ports[0])
            viewer = _PROTOCOLS[protocol](*ports, names)

            def reached(rate: float) -> Optional[float]:
                controller.change_rate(rate)
                _received(viewer, _SETTLING)
                topics = _received(viewer, MEASURING)
                spans = []
                for each in topics:
                    name, begin = viewer.stamp(each.first)
                    span = viewer.stamp(each.last)[1] - begin
                    spans.append(span)
                    period = next(p for topic, p in _PERIODS.items() if name.endswith(topic))
                    if round(span / period) != each.count - 1:
                        return None
                return max(spans) / MEASURING if len(topics) == len(names) else None

            return {"times real time": highest_rate(reached)}
        finally:
            server.end()
