"""Misdeeds of a bridge's clients: other clients notice none of them."""

import json
import os
import random
import resource
import signal
import socket
import struct
import subprocess
import threading
import time
from contextlib import ExitStack, suppress
from pathlib import Path
from typing import Any, Callable, Dict, List
from urllib.parse import urlsplit

from soak.bridge_process import LIMIT, Bridge, Closed, Data, Peer
from soak.bridge_witnesses import FUZZED
from soak.findings import Findings
from soak.random_bridge_messages import RandomMessages, known_services
from waiting import wait_until

BATCHES, BATCH = 200, 5  # of random messages to each protocol
STORM = 4.0  # s
PUBLISHED = 60  # messages to each topic of stalled readers
LARGE = "x" * 900_000  # nearly the longest that a message may be
MODEL = """
bodies: [{name: b, footprints: [{type: circle, density: 1, radius: $eval
  (function() local i = 0; while i < %s do i = i + 1 end; return -1 end)()}]}]
"""
SLOW_MODEL = MODEL % "1e10"
ROS2_MISDEEDS = str(Path(__file__).with_name("ros2_misdeeds.py"))
INTERNAL_ERROR = 1011
"""The code by which a WebSocket is closed after an exception in the server."""

HALF_REQUESTS = (
    *(b"", b"\x00", b"G", b"GET", b"GET /", b"GET / HTTP/1.1\r\n"),
    b"GET / HTTP/1.1\r\nHost: x\r\n",
    b"GET / HTTP/1.1\r\nUpgrade: websocket\r\n",
    b"\x16\x03\x01\x02\x00\x01\x00\x01\xfc\x03\x03",
)
WRONG_REQUESTS = (
    *(b"\n\n", b"GET\r\n\r\n", b"GET / HTTP/9.9\r\n\r\n", b"POST / HTTP/1.1\r\nHost: x\r\n\r\n"),
    *(b"\xff\xfe\xfd\r\n\r\n", b"GET / HTTP/1.1\r\nno colon\r\n\r\n", b"PRI * HTTP/2.0\r\n\r\n"),
    *(b"GET http://[ HTTP/1.1\r\n\r\n", b"GET //[::: HTTP/1.1\r\nHost: x\r\n\r\n"),
    b"GET " + b"/" * 9000,
    *(b"GET / HTTP/1.1\r\n" + b"X: y\r\n" * 200 + b"\r\n", b"GET / HTTP/1.1\r\nX: " + b"y" * 9000),
    *(b"GET /%00%ff%2e%2e/ HTTP/1.1\r\nHost: x\r\n\r\n", b"GET /\x00 HTTP/1.1\r\nHost: x\r\n\r\n"),
    b"GET / HTTP/1.1\r\nHost: x\r\nContent-Length: -1\r\n\r\n",
    b"GET / HTTP/1.1\r\nHost: x\r\nContent-Length: 99999999999999999999\r\n\r\n",
    b"GET / HTTP/1.1\r\nHost: x\r\nTransfer-Encoding: chunked\r\n\r\nffffffff\r\n",
    b"GET / HTTP/1.1\r\nHost: x\r\nUpgrade: websocket\r\nOrigin: http://[\r\n\r\n",
    b"GET / HTTP/1.1\r\nUpgrade: websocket\r\nOrigin: a\r\nOrigin: b\r\n\r\n",
    b"GET / HTTP/1.1\r\nHost: x\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n\r\n",
    b"GET / HTTP/1.1\r\nHost: x\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n"
    b"Sec-WebSocket-Key: \xff\r\nSec-WebSocket-Version: 12\r\n\r\n",
    b"GET /?token=%ff%00 HTTP/1.1\r\nHost: x\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n\r\n",
)  # fmt: skip
FRAMES = (
    *(b"\x81\x85\x00\x00\x00\x00ab", b"\xff\xff", b"\x83\x80\x00\x00\x00\x00", b"\x81\x05hello"),
    *(b"\x81\xff" + b"\xff" * 8, b"\x81\xff\x00\x00\x00\x00\x7f\xff\xff\xff\x00\x00\x00\x00x"),
    *(b"\x80\x81\x00\x00\x00\x00a", b"\x89\xfe\x04\x00" + bytes(1028), b"\x88\x81" + bytes(5)),
    *(b"\x81\x82\x00\x00\x00\x00\xff\xfe", b"\xc1\x81\x00\x00\x00\x00a", b"\x01\x81" + bytes(5)),
    b"\x01\x81\x00\x00\x00\x00a" * 50,
)  # fmt: skip


MISDEEDS = (
    *("random_messages_of_rosbridge", "random_messages_of_foxglove", "wrong_http", "broken_frames"),
    *("silent_connections", "killed_clients", "subscription_storm", "many_ids", "many_fragments"),
    *("unanswered_calls", "many_calls", "slow_calls", "stalled_readers", "no_descriptors"),
    "many_parameters",
)


class Misdeeds:
    """Misdeeds of clients, with random choices. `MISDEEDS` are its methods.

    Args:
        bridge: the bridge.
        rng: generator of all random choices.
        findings: what was found.
        what: names the seed.
        share: of the usual number of messages, and of the usual time.
    """

    def __init__(
        self,
        bridge: Bridge,
        rng: random.Random,
        findings: Findings,
        what: str,
        share: float = 1.0,
    ) -> None:
        self._bridge = bridge
        self._rng = rng
        self._findings = findings
        self._what = what
        self._share = share
        self._batches = round(share * BATCHES)
        self._published = round(share * PUBLISHED)
        self._storm = share * STORM

    # Decoders

    def random_messages_of_rosbridge(self) -> None:
        """Each is answered or ignored within a time, and the client stays connected."""
        messages = self._random_messages()
        peer = Peer(self._bridge.rosbridge)
        for number in range(self._batches):
            batch = [messages.rosbridge() for _ in range(BATCH)]
            mark = f"mark {number}"
            probe = {"op": "call_service", "service": "/rosapi/get_time", "id": mark}
            if not self._is_survived(peer, batch, json.dumps(probe), mark.encode()):
                peer.close()
                peer = Peer(self._bridge.rosbridge)
        peer.close()

    def random_messages_of_foxglove(self) -> None:
        """The same in the other protocol."""
        messages = self._random_messages()
        peer = Peer(self._bridge.foxglove)
        channels, services = self._offers(peer)
        for number in range(self._batches):
            batch = [messages.foxglove(channels, services) for _ in range(BATCH)]
            mark = f"mark{number}"
            if not self._is_survived(peer, batch, json.dumps({"op": mark}), mark.encode()):
                peer.close()
                peer = Peer(self._bridge.foxglove)
                channels, services = self._offers(peer)
        peer.close()

    def _is_survived(self, peer: Peer, batch: List[Data], probe: str, mark: bytes) -> bool:
        """Sends messages and a probe. Returns whether the connection lasts until its answer."""
        self._findings.counts["random messages to bridges"] += len(batch)
        messages = f"after one of {', '.join(map(_shown, batch))}"
        end = time.monotonic() + LIMIT
        try:
            for data in [*batch, probe]:
                peer.send(data)
            while time.monotonic() < end:
                answer = peer.receive(end - time.monotonic())
                if mark in (answer.encode() if isinstance(answer, str) else answer):
                    return True
        except Closed as error:
            is_fault = error.code in (None, INTERNAL_ERROR)
            self._findings.expect(not is_fault, f"{self._what}: {error} {messages}")
            return False
        except OSError:
            pass
        self._findings.expect(False, f"{self._what}: no answer for {LIMIT} s {messages}")
        return False

    def _random_messages(self) -> RandomMessages:
        with Peer(self._bridge.rosbridge) as peer:
            names = ask(peer, "/rosapi/services")["services"]
            kinds = {
                name: ask(peer, "/rosapi/service_type", service=name)["type"] for name in names
            }
            found = ask(peer, "/rosapi/topics")
        topics = dict(zip(found["topics"], found["types"]))
        ours = ("/flatland_server", "/clock", "/tf", "/rosout", "/diagnostics")
        topics = {name: kind for name, kind in topics.items() if not name.startswith(ours)}
        return RandomMessages(self._rng, {**topics, **FUZZED}, known_services(kinds))

    def _offers(self, peer: Peer) -> Any:
        """The numbers of the channels, and the names of the services by their numbers."""
        channels: List[int] = []
        services: Dict[int, str] = {}
        while not services:
            message = json.loads(peer.receive())
            if message["op"] == "advertise":
                channels += [each["id"] for each in message["channels"]]
            if message["op"] == "advertiseServices":
                services = {each["id"]: each["name"] for each in message["services"]}
        return channels, services

    # Connections

    def wrong_http(self) -> None:
        """Requests that are none: each is refused, and is no error of the server's."""
        with ExitStack() as stack:
            connections = [stack.enter_context(self._raw()) for _ in WRONG_REQUESTS]
            for connection, request in zip(connections, WRONG_REQUESTS):
                connection.sendall(request)
            end = time.monotonic() + 1.0  # some have no end, and no answer
            for connection, request in zip(connections, WRONG_REQUESTS):
                connection.settimeout(max(0.01, end - time.monotonic()))
                with suppress(OSError):
                    is_fault = connection.recv(1000).startswith(b"HTTP/1.1 500")
                    self._findings.expect(not is_fault, f"{self._what}: 500 for {request[:80]!r}")

    def broken_frames(self) -> None:
        """WebSocket frames that are none, or cut, or promise what does not follow."""
        for frame in FRAMES:
            with self._peer() as peer, suppress(ConnectionError, BrokenPipeError):
                peer.socket.sendall(frame)

    def silent_connections(self) -> None:
        """Connections on which nothing follows, or half a request: others still connect."""
        with ExitStack() as stack:
            for _ in range(self._rng.randint(50, 150)):
                connection = stack.enter_context(self._raw())
                connection.sendall(self._rng.choice(HALF_REQUESTS))
            with Peer(self._bridge.rosbridge) as peer:
                ask(peer, "/rosapi/get_time")

    def killed_clients(self) -> None:
        """Clients that are gone in the middle of a message, a call or their own connection."""
        for _ in range(20):
            with self._peer() as peer:
                with suppress(OSError):
                    for topic in FUZZED:
                        peer.send(_subscribe(topic, self._rng.choice(["none", "cbor"])))
                    peer.send(_call("/spawn_model_from_string", yaml_path=MODEL % "1e6", name="x"))
                    data = b"\x81\xfe\xff\xff\x00\x00\x00\x00" + b"{" * self._rng.randrange(9000)
                    peer.socket.sendall(data)
                linger = struct.pack("ii", 1, 0)  # a reset instead of an end
                if self._rng.random() < 0.5:
                    peer.socket.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, linger)

    def no_descriptors(self) -> None:
        """More connections than the bridge may have files open."""
        pid = self._bridge.process.pid
        soft, hard = resource.prlimit(pid, resource.RLIMIT_NOFILE)
        used = self._bridge.usage().open_files
        most = max(map(int, os.listdir(f"/proc/{pid}/fd"))) + 10
        resource.prlimit(pid, resource.RLIMIT_NOFILE, (most, hard))
        try:
            with ExitStack() as stack:
                for _ in range(60):
                    stack.enter_context(self._raw())
                wait_until(lambda: self._bridge.usage().open_files > used, "the connections")
                time.sleep(0.5)  # long enough for errors in the log; there is nothing to wait for
        finally:
            resource.prlimit(pid, resource.RLIMIT_NOFILE, (soft, hard))
        with Peer(self._bridge.rosbridge) as peer:
            ask(peer, "/rosapi/get_time")

    # Storms

    def subscription_storm(self) -> None:
        """Several clients subscribe and unsubscribe as fast as they can, also to new topics."""
        end = time.monotonic() + self._storm
        topics = [*FUZZED, "/scan", "/tf", "/clock", "/flatland_server/model_states"]

        def storm(rng: random.Random) -> None:
            with Peer(self._bridge.rosbridge) as peer, suppress(OSError):
                while time.monotonic() < end:
                    new = [f"/storm_{rng.randrange(10_000)}" for _ in range(20)]
                    for topic in [*rng.sample(topics, 8), *new]:
                        for number in rng.sample(range(3), 2):
                            how = rng.choice(["none", "cbor", "cbor-raw"])
                            throttle = {"id": number, "throttle_rate": rng.choice([0, 0, 50])}
                            peer.send(_subscribe(topic, how, **throttle))
                        peer.send(json.dumps({"op": "unsubscribe", "topic": topic, "id": 1}))
                        peer.send(json.dumps({"op": "unsubscribe", "topic": topic}))
                    _drain(peer)

        self._at_once([lambda r=r: storm(r) for r in self._rngs(4)])

    def many_ids(self) -> None:
        """A client with a thousand ids, each nearly as long as a message may be."""
        message = self._rng.choice(
            [
                {"op": "subscribe", "topic": "/fuzzed_0"},
                {"op": "fragment", "num": 0, "total": 2, "data": "{"},
            ]
        )
        self._flood(json.dumps({**message, "id": f"{number} {LARGE}"}) for number in range(1000))

    def many_fragments(self) -> None:
        """A client that sends one part each of a thousand messages."""
        part = {"op": "fragment", "num": 0, "total": 2, "data": LARGE}
        self._flood(json.dumps({**part, "id": f"{number}"}) for number in range(1000))

    def unanswered_calls(self) -> None:
        """A service of a client that answers no call: others call it a thousand times."""
        with Peer(self._bridge.rosbridge) as offering:
            service = {"op": "advertise_service", "service": "/never", "type": "std_srvs/Empty"}
            offering.send(json.dumps(service))
            ask(offering, "/rosapi/get_time")
            self._flood(_call("/never", text=LARGE) for _ in range(1000))

    def many_parameters(self) -> None:
        """A client that sets long parameters, most of which are refused."""
        value = json.dumps(LARGE)
        deep = "[" * 90 + "[]," * 200_000 + "[]" + "]" * 90
        parameters = {**{f"/many/{number}": value for number in range(20)}, "/many/deep": deep}
        self._flood(
            _call("/rosapi/set_param", name=name, value=value) for name, value in parameters.items()
        )
        with Peer(self._bridge.rosbridge) as peer:
            ask(peer, "/rosapi/delete_param", name="/many")

    def many_calls(self) -> None:
        """A hundred calls of some clients at once, of which each takes a moment."""

        def call() -> None:
            with Peer(self._bridge.rosbridge) as peer, suppress(TimeoutError):  # on busy cores
                for _ in range(10):
                    peer.send(_call("/spawn_model_from_string", yaml_path=MODEL % "1e6", name="x"))
                ask(peer, "/rosapi/get_time")

        self._at_once([call] * 10)

    def slow_calls(self) -> None:
        """Fifty calls that each take half a second of a worker."""
        with Peer(self._bridge.rosbridge) as peer, suppress(OSError):
            for number in range(50):
                slow = {"yaml_path": SLOW_MODEL, "name": f"slow_{number}"}
                peer.send(_call("/spawn_model_from_string", **slow))
            end = time.monotonic() + 2 * self._storm
            while time.monotonic() < end:
                with suppress(TimeoutError):
                    peer.receive(0.5)

    def stalled_readers(self) -> None:
        """Clients that read nothing of large messages on many topics."""
        topics = [f"/large_{number}" for number in range(20)]
        with ExitStack() as stack:
            for compression in ("none", "cbor", "cbor-raw"):
                reader = stack.enter_context(Peer(self._bridge.rosbridge, buffer=4096))
                for topic in topics:
                    reader.send(_subscribe(topic, compression))
            content = {"type": "std_msgs/String", "msg": {"data": LARGE}}
            advertised = [json.dumps({"op": "advertise", "topic": t, **content}) for t in topics]
            published = [json.dumps({"op": "publish", "topic": t, **content}) for t in topics]
            self._flood([*advertised, *published * self._published])

    # ROS 2

    def ros2_node(self) -> None:
        """Misdeeds of a node of ROS 2, beside which another one is served; both are killed."""
        command = [self._bridge.python, ROS2_MISDEEDS, str(self._rng.random()), str(self._share)]
        ended = subprocess.run(
            command, env=self._bridge.environment, capture_output=True, text=True, check=False
        )
        is_killed = ended.returncode == -signal.SIGKILL
        self._findings.expect(is_killed, f"{self._what}: {ended.stderr[-1000:]}")

    # Parts of these

    def _flood(self, messages: Any) -> None:
        """Sends messages until there are no more, or the bridge closes the connection."""
        with Peer(self._bridge.rosbridge) as peer:
            try:
                for data in messages:
                    peer.send(data)
                    _drain(peer)
                ask(peer, "/rosapi/get_time")
            except Closed as error:
                is_fault = error.code == INTERNAL_ERROR
                self._findings.expect(not is_fault, f"{self._what}: the client is {error}")
            except OSError:
                pass  # it is cut off, or has to wait: others must not

    def _at_once(self, actions: List[Callable[[], None]]) -> None:
        threads = [threading.Thread(target=each, daemon=True) for each in actions]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()

    def _rngs(self, count: int) -> List[random.Random]:
        return [random.Random(self._rng.random()) for _ in range(count)]

    def _url(self) -> str:
        return self._rng.choice([self._bridge.rosbridge, self._bridge.foxglove])

    def _peer(self) -> Peer:
        return Peer(self._url())

    def _raw(self) -> socket.socket:
        """A connection on which nothing has been sent."""
        place = urlsplit(self._url())
        assert place.hostname is not None
        assert place.port is not None
        return socket.create_connection((place.hostname, place.port), LIMIT)


def ask(peer: Peer, service: str, /, **arguments: Any) -> Any:
    """Calls a service of rosbridge, and returns the fields of its response.

    Raises:
        OSError: there is none.
    """
    peer.send(_call(service, **arguments))
    while True:
        message = json.loads(peer.receive())
        if message["op"] == "service_response" and message.get("id") == "soak":
            return message["values"]


def restore(bridge: Bridge) -> None:
    """Undoes what calls may have done to the simulation: it runs at the usual rate."""
    with Peer(bridge.rosbridge) as peer:
        ask(peer, "/pause")  # ends steps
        ask(peer, "/change_rate", rate=1.0)
        ask(peer, "/reset")
        ask(peer, "/resume")


def _call(service: str, /, **arguments: Any) -> str:
    return json.dumps({"op": "call_service", "service": service, "id": "soak", "args": arguments})


def _subscribe(topic: str, compression: str, **options: Any) -> str:
    return json.dumps({"op": "subscribe", "topic": topic, "compression": compression, **options})


def _drain(peer: Peer) -> None:
    """Reads what there is."""
    with suppress(TimeoutError):
        while True:
            peer.receive(0.0)


def _shown(data: Data) -> str:
    """A message of a log, short, with its size."""
    return f"{data[:200]!r} ({len(data)})"
