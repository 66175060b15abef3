"""The topics of a graph for ROS 2, over DDS: `flatland serve --ros2`.

Services are topics: the implementations of ROS 2 disagree on services over DDS.
"""

import logging
import os
import socket
import threading
from contextlib import suppress
from functools import partial
from typing import Any, Callable, Dict, Iterator, List, Optional, Set, Tuple

from cyclonedds.core import DDSException, GuardCondition, WaitSet
from cyclonedds.domain import Domain, DomainParticipant
from cyclonedds.qos import Policy, Qos
from cyclonedds.util import duration

from flatland_bridge.budget import Budgets
from flatland_bridge.call_topics import CallTopics
from flatland_bridge.dds_topics import Input, Output, Profile, default_profile, open_writer
from flatland_bridge.dds_types import DISCOVERY_TOPIC, DdsTypes, dds_topic
from flatland_bridge.graph import BridgeError, Graph
from flatland_server.messages.message_types import get
from flatland_server.real_time_timer import RealTimeTimer

logger = logging.getLogger(__name__)

NODE = "flatland_server"
"""The name of the node."""

_PERIOD = 0.2
"""Real time between two looks for new topics and subscribers [s]."""
_LARGEST_DOMAIN = 232
"""The ports of higher ones do not exist."""

_FIRST_PORT, _PORTS = 7400, 250
"""The ports of a domain, by the standard: for participants two each, from the eleventh on."""
_MOST_PARTICIPANTS = 100
"""Participants on this machine that are found."""

_TWIST, _TWIST_STAMPED = "geometry_msgs/Twist", "geometry_msgs/TwistStamped"

_CONFIG = """<CycloneDDS><Domain Id="any">{}
<Internal><Watermarks><WhcHigh>1GB</WhcHigh></Watermarks></Internal></Domain></CycloneDDS>"""
"""Writers never wait for a slow reader: they keep a few messages of any size."""
_INTERFACE = "<General><Interfaces><NetworkInterface {}/></Interfaces></General>"
_THIS_MACHINE = """<General><Interfaces><NetworkInterface address="127.0.0.1"/></Interfaces>
<AllowMulticast>false</AllowMulticast>
<MaxMessageSize>65500B</MaxMessageSize><FragmentSize>65000B</FragmentSize></General>
<Discovery><ParticipantIndex>auto</ParticipantIndex>
<MaxAutoParticipantIndex>{}</MaxAutoParticipantIndex><SPDPInterval>1s</SPDPInterval>
<Peers><Peer address="127.0.0.1"/></Peers></Discovery>"""
"""Packets to this machine can be large. Without multicast, discovery is a packet to each port."""


class DdsServer:
    """A participant of DDS with one node. It works on a thread of its own, until it is closed.

    Args:
        graph: the topics and services.
        address: of the network interface, or a name of it; None is this machine alone, "" any.
        distribution: of ROS 2, for its types.

    Attributes:
        domain: its number, from the variable ROS_DOMAIN_ID.

    Raises:
        FlatlandError: the domain, the address or the distribution cannot be used.
    """

    def __init__(self, graph: Graph, address: Optional[str], distribution: str) -> None:
        self.domain = _domain()
        self._graph = CallTopics(graph)
        self._types = DdsTypes(distribution)
        try:
            self._entity = Domain(self.domain, configuration(self.domain, address))
            self._participant = DomainParticipant(self.domain, Qos(Policy.Userdata(b"enclave=/;")))
            if address is None:
                _keep_to_this_machine(self.domain)
        except (DDSException, OSError, UnicodeEncodeError) as error:
            where = "127.0.0.1" if address is None else address or "the network"
            raise BridgeError(f"DDS cannot use {where}: {error}") from None
        self._budget = Budgets().open()  # of all that ROS 2 publishes
        self._waitset = WaitSet(self._participant)
        self._guard = GuardCondition(self._participant)
        self._waitset.attach(self._guard)
        self._is_awake = self._is_ending = False
        self._outputs: Dict[Tuple[str, str, bool], Output] = {}
        self._inputs: Dict[Tuple[str, str], Input] = {}
        self._refused: Set[Tuple[str, str]] = set()
        self._discovery = open_writer(
            self._participant,
            DISCOVERY_TOPIC,
            self._types.discovery_class(),
            Profile(depth=1, is_latched=True),
        )
        self._thread = threading.Thread(target=self._run, name="dds", daemon=True)
        self._thread.start()

    def close(self) -> None:
        """Leaves the domain."""
        self._is_ending = True
        self._guard.set(True)
        self._thread.join()
        self._graph.close()
        for output in self._outputs.values():
            output.close()
        # Entities are deleted with their last reference, and each before that which it is in.
        self._outputs.clear()
        self._inputs.clear()
        del self._discovery, self._waitset, self._guard
        del self._participant
        del self._entity

    def _run(self) -> None:
        timer = RealTimeTimer(_PERIOD)
        while not self._is_ending:
            triggered = self._waitset.wait(duration(seconds=_PERIOD))
            has_received = triggered > self._is_awake  # the guard is one of them
            self._guard.set(False)
            self._is_awake = False
            if has_received:
                for each in self._inputs.values():
                    each.receive()
            if timer.check_update():
                self._follow_graph()
            for key in list(self._outputs):
                self._send(*key)

    def _send(self, topic: str, kind: str, is_latched: bool) -> None:
        """Sends what waits for a topic's subscribers."""
        key = topic, kind, is_latched
        try:
            self._outputs[key].send()
        except Exception:  # of a message that has other fields than its type, for one
            self._refused.add((topic, kind))
            self._outputs.pop(key).close()
            logger.exception("%s is no longer a topic of ROS 2", topic)

    def _wake(self) -> None:
        """Ends the thread's wait; for any thread."""
        if not self._is_awake:
            self._is_awake = True
            self._guard.set(True)

    def _follow_graph(self) -> None:
        """Opens and closes topics as they come and go, and announces them."""
        before = self._entities()
        topics = self._graph.topics
        published = {(*each, each[0] in topics.latched) for each in topics.published.items()}
        gone = set(self._outputs).difference(published)
        gone.update(key for key, each in self._outputs.items() if not each.follow())
        for key in gone:
            self._outputs.pop(key).close()
        for topic, kind, is_latched in sorted(published.difference(self._outputs)):
            self._open(topic, kind, partial(self._open_output, is_latched=is_latched))
        subscribed = {each for each in topics.subscribed.items() if each[0] not in topics.published}
        stamped = {(topic, _TWIST_STAMPED) for topic, kind in subscribed if kind == _TWIST}
        for each in set(self._inputs).difference(subscribed, stamped):
            self._waitset.detach(self._inputs.pop(each).reader)
        for topic, kind in sorted((subscribed | stamped).difference(self._inputs)):
            to_graph = _twist_of if (topic, kind) in stamped - subscribed else _unchanged
            self._open(topic, kind, partial(self._open_input, to_graph=to_graph))
        if self._entities() != before:
            self._announce()

    def _entities(self) -> List[object]:
        return [*self._inputs.values(), *self._outputs.values()]

    def _open(self, topic: str, kind: str, open_it: Callable[[str, str, str, Any], None]) -> None:
        """Opens a topic, unless ROS 2 has no such name or type."""
        if (topic, kind) in self._refused:
            return
        try:
            name = dds_topic(topic)
            if not name:
                raise BridgeError("ROS 2 allows no topic of this name")
            open_it(topic, kind, name, self._types.message_class(get(kind)))
        except Exception as error:  # of any kind, from rosbags and cyclonedds
            self._refused.add((topic, kind))
            logger.info("%s [%s] is not a topic of ROS 2: %s", topic, kind, error)

    def _open_output(
        self, topic: str, kind: str, name: str, message_class: Any, *, is_latched: bool
    ) -> None:
        profile = default_profile(topic, kind, is_latched)
        writer = open_writer(self._participant, name, message_class, profile)
        output = Output(writer, self._graph, topic, profile, self._wake)
        self._outputs[topic, kind, is_latched] = output

    def _open_input(
        self,
        topic: str,
        kind: str,
        name: str,
        message_class: Any,
        *,
        to_graph: Callable[[Any], Any],
    ) -> None:
        each = Input(
            self._participant,
            name,
            message_class,
            get(kind),
            lambda message: self._graph.publish(topic, to_graph(message), self._budget),
        )
        self._inputs[topic, kind] = each
        self._waitset.attach(each.reader)

    def _announce(self) -> None:
        """Tells the nodes of ROS 2 which topics are the node's."""
        message = self._types.discovery_message(
            NODE,
            self._participant.guid.bytes,
            [each.reader.guid.bytes for each in self._inputs.values()],
            [each.writer.guid.bytes for each in self._outputs.values()],
        )
        self._discovery.write(message)


def _unchanged(message: Any) -> Any:
    return message


def _twist_of(message: Any) -> Any:
    return message.twist


def _keep_to_this_machine(domain: int) -> None:
    """Lets the sockets of a domain receive from this machine only: DDS listens at all addresses.

    Raises:
        OSError: the system does not allow it.
    """
    first = _FIRST_PORT + _PORTS * domain
    for each in udp_sockets():
        if first <= each.getsockname()[1] < first + _PORTS:
            each.setsockopt(socket.SOL_SOCKET, socket.SO_BINDTODEVICE, b"lo")


def udp_sockets() -> Iterator[socket.socket]:
    """Duplicates of this process's UDP sockets, each of them until the next one."""
    folder = "/proc/self/fd"
    for name in os.listdir(folder):
        with suppress(OSError):  # closed since
            if not os.readlink(f"{folder}/{name}").startswith("socket:"):
                continue
            with socket.fromfd(int(name), socket.AF_INET, socket.SOCK_DGRAM) as each:
                options = (socket.SO_DOMAIN, socket.SO_TYPE)
                kinds = [each.getsockopt(socket.SOL_SOCKET, option) for option in options]
                if kinds == [socket.AF_INET, socket.SOCK_DGRAM]:
                    yield each


def _domain() -> int:
    text = os.environ.get("ROS_DOMAIN_ID") or "0"
    if not (text.isascii() and text.isdecimal() and int(text) <= _LARGEST_DOMAIN):
        raise BridgeError(f'ROS_DOMAIN_ID: expected 0 to {_LARGEST_DOMAIN}, found "{text}"')
    return int(text)


def configuration(domain: int, address: Optional[str]) -> str:
    """The configuration of DDS; that of the variable CYCLONEDDS_URI is not used.

    Args:
        domain: its number.
        address: as for `DdsServer`.

    Raises:
        OSError: there is no such address.
    """
    if address is None:
        pairs = (65535 - 11 - _FIRST_PORT - _PORTS * domain) // 2
        return _CONFIG.format(_THIS_MACHINE.format(min(pairs, _MOST_PARTICIPANTS)))
    interface = 'autodetermine="true"'
    if address:
        interface = f'address="{socket.gethostbyname(address)}"'
    return _CONFIG.format(_INTERFACE.format(interface))
