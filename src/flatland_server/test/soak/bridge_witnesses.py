"""Honest clients of a bridge, beside those that misbehave: they go on being served."""

import itertools
import json
import struct
import threading
import time
from typing import Any, Dict, List, Optional, Tuple

import cbor2
from soak.bridge_process import LIMIT, Bridge, Closed, Data, Peer
from soak.findings import Findings
from waiting import wait_until

STATE = "/flatland_server/state"
STREAMS = (STATE, "/clock", "/tf", "/scan")
FUZZED = {f"/fuzzed_{number}": kind for number, kind in enumerate([
    "std_msgs/UInt8", "std_msgs/Int64", "std_msgs/Float32", "std_msgs/String", "std_msgs/Time",
    "std_msgs/UInt8MultiArray", "std_msgs/Float64MultiArray", "nav_msgs/Path",
    "sensor_msgs/Image", "diagnostic_msgs/DiagnosticArray",
])}  # fmt: skip
"""Topics and types that are published by the clients that misbehave, and read by honest ones."""
QUESTION = "/get_model_markers"
"""A service of the server's, which answers an empty request with an error."""


class Rosbridge:
    """Messages of an honest client of rosbridge.

    Args:
        compression: of its subscriptions: "none", "cbor" or "cbor-raw".
    """

    def __init__(self, compression: str) -> None:
        self.name = f"rosbridge ({compression})"
        self._compression = compression

    def url(self, bridge: Bridge) -> str:
        return bridge.rosbridge

    def begin(self) -> List[Data]:
        asked = {"op": "subscribe", "compression": self._compression, "queue_length": 1}
        return [json.dumps({**asked, "topic": topic}) for topic in (*STREAMS, *FUZZED)]

    def ask(self, number: int) -> Data:
        call = {"op": "call_service", "service": QUESTION, "args": {}}
        return json.dumps({**call, "id": f"honest {number}"})

    def understand(self, data: Data) -> Tuple[Optional[str], Optional[int], List[Data]]:
        """The topic of a message, the number of the call that it answers, and what to send."""
        message: Any = json.loads(data) if isinstance(data, str) else cbor2.loads(data)
        if message["op"] == "publish":
            return message["topic"], None, []
        is_answer = message["op"] == "service_response"
        return None, int(str(message["id"]).split()[-1]) if is_answer else None, []


class Foxglove:
    """Messages of an honest client of Foxglove's protocol."""

    name = "Foxglove"

    def __init__(self) -> None:
        self._topics: Dict[int, str] = {}
        self._question = 0

    def url(self, bridge: Bridge) -> str:
        return bridge.foxglove

    def begin(self) -> List[Data]:
        return []

    def ask(self, number: int) -> Data:
        return struct.pack("<BIII", 2, self._question, number, 4) + b"json{}"

    def understand(self, data: Data) -> Tuple[Optional[str], Optional[int], List[Data]]:
        """As of `Rosbridge`."""
        if isinstance(data, bytes):
            number = struct.unpack_from("<I", data, 1)[0]
            if data[0] == 1:
                return self._topics.get(number), None, []
            return None, struct.unpack_from("<I", data, 5)[0] if data[0] == 3 else None, []
        message = json.loads(data)
        if message["op"] == "serviceCallFailure":
            return None, message["callId"], []
        for service in message.get("services", ()):
            if service["name"] == QUESTION:
                self._question = service["id"]
        channels = message["channels"] if message["op"] == "advertise" else ()
        new = {each["id"]: each["topic"] for each in channels if each["topic"] in STREAMS}
        self._topics.update(new)
        asked = [{"id": number, "channelId": number} for number in new]
        return None, None, [json.dumps({"op": "subscribe", "subscriptions": asked})] if new else []


class Witness:
    """An honest client on a thread of its own. It notes how long it waits.

    Args:
        bridge: the bridge.
        protocol: `Rosbridge` or `Foxglove`.
    """

    def __init__(self, bridge: Bridge, protocol: Any) -> None:
        self._protocol = protocol
        self._peer = Peer(protocol.url(bridge))
        self._asked: Optional[float] = None  # when the last call was made, until it is answered
        self._seen: Dict[str, float] = {}  # when the last message of a topic came
        self._waits = {"stream": 0.0, "call": 0.0}  # the longest ones [s]
        self._end = ""
        self._goes_on = True
        for data in protocol.begin():
            self._peer.send(data)
        self._thread = threading.Thread(target=self._run, daemon=True)
        self._thread.start()
        wait_until(lambda: STATE in self._seen, f"{protocol.name} to begin")

    def check(self, findings: Findings, what: str) -> None:
        """It is connected, and has not waited for long since the last check."""
        name, now = f"{what}: an honest client of {self._protocol.name}", time.monotonic()
        findings.expect(not self._end, f"{name} has lost its connection: {self._end}")
        waits, self._waits = self._waits, {"stream": 0.0, "call": 0.0}
        waits["stream"] = max(waits["stream"], now - self._seen[STATE])
        waits["call"] = max(waits["call"], now - (self._asked or now))
        for kind, seconds in waits.items():
            wait = f"{name} has waited {seconds:.1f} s for its {kind}"
            findings.expect(self._end or seconds < LIMIT, wait)

    def missing(self, since: float) -> List[str]:
        """Topics on which it has received nothing since a time of `time.monotonic`."""
        names = [topic for topic in STREAMS if self._seen.get(topic, 0.0) < since]
        return [f"{name} ({self._protocol.name})" for name in names if not self._end]

    def close(self) -> None:
        self._goes_on = False
        self._thread.join()
        self._peer.close()

    def _run(self) -> None:
        numbers = itertools.count(1)
        try:
            while self._goes_on:
                try:
                    data = self._peer.receive(0.2)
                except TimeoutError:
                    continue
                self._note(*self._protocol.understand(data))
                if self._asked is None and STATE in self._seen:
                    self._asked = time.monotonic()
                    self._number = next(numbers)
                    self._peer.send(self._protocol.ask(self._number))
        except (Closed, OSError) as error:
            self._end = str(error)

    def _note(self, topic: Optional[str], answered: Optional[int], answers: List[Data]) -> None:
        now = time.monotonic()
        if topic is not None:
            if topic == STATE and topic in self._seen:
                self._waits["stream"] = max(self._waits["stream"], now - self._seen[topic])
            self._seen[topic] = now
        if answered is not None and self._asked is not None and answered == self._number:
            self._waits["call"] = max(self._waits["call"], now - self._asked)
            self._asked = None
        for data in answers:
            self._peer.send(data)


def witnesses(bridge: Bridge) -> List[Witness]:
    """An honest client of each protocol and encoding."""
    forms = [*map(Rosbridge, ("none", "cbor", "cbor-raw")), Foxglove()]
    return [Witness(bridge, form) for form in forms]
