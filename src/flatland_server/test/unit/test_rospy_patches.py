"""The patches of rospy, each refused where rospy lacks something that it relies on."""

import ast
import importlib
from functools import reduce
from pathlib import Path
from types import SimpleNamespace
from typing import Any, Iterator, List, Tuple

import pytest
import rospy
from rosgraph_msgs.msg import Clock

from flatland_server.messages.wire_form import LENGTH, serialized
from flatland_server.ros import rospy_patches
from flatland_server.ros.clock import ClockPublisher
from flatland_server.ros.ros_transport import RosTransport
from flatland_server.ros.rospy_patches import PATCHES, RospyCalls, install
from flatland_server.ros.rospy_patches.rospy_checks import Requirement
from flatland_server.timekeeper import Timekeeper

ROS = Path(rospy_patches.__file__).resolve().parents[1]

REQUIREMENTS = [
    pytest.param(name, requirement, id=f"{name}-{requirement.path}")
    for name in PATCHES
    for requirement in importlib.import_module(f"{rospy_patches.__name__}.{name}").REQUIREMENTS
]
REPLACED = {
    "nonblocking_connection": ["is_connected", "send_framed", "outbox"],
    "registration": ["batch_registration", "wait_until_registered"],
    "local_time": ["take_over_time"],
    "latched_topics": ["forget_latched"],
}
"""The calls that each patch replaces."""


def owner_of(requirement: Requirement) -> Tuple[Any, str]:
    """The module or class that has the attribute, and the attribute's name."""
    module, _, attributes = requirement.path.partition(":")
    *owners, name = attributes.split(".")
    return reduce(getattr, owners, importlib.import_module(module)), name


def patches_in_use(calls: RospyCalls) -> List[str]:
    """The patches in use, of those that replace calls."""
    plain = RospyCalls()
    return [
        patch
        for patch, names in REPLACED.items()
        if all(getattr(calls, name) is not getattr(plain, name) for name in names)
    ]


def refused(text: str) -> List[str]:
    """The patches that a log says are switched off."""
    return [name for name in PATCHES if f"{name} (" in text]


def test_all_patches_fit_this_rospy(unpatched_rospy, caplog):
    calls = install()

    assert patches_in_use(calls) == list(REPLACED)
    assert caplog.text == ""
    assert rospy.topics.QueuedConnection.__name__ == "NonblockingConnection"
    assert not hasattr(rospy.topics.Poller(), "poller")  # rospy's own, with a file descriptor


@pytest.mark.parametrize(("name", "requirement"), REQUIREMENTS)
def test_a_patch_is_left_out_if_an_attribute_is_missing(
    name, requirement, unpatched_rospy, monkeypatch, caplog
):
    owner, attribute = owner_of(requirement)
    if attribute == "__init__":  # every class has one
        monkeypatch.setattr(owner, attribute, lambda self: None)
    else:
        monkeypatch.delattr(owner, attribute)

    calls = install()

    assert name in refused(caplog.text)
    assert PATCHES[name] in caplog.text
    assert len(caplog.records) == 1
    assert name not in patches_in_use(calls)
    expected = set(REPLACED) - set(refused(caplog.text))
    assert set(patches_in_use(calls)) == expected
    if name == "nonblocking_connection":
        assert getattr(rospy.topics, "QueuedConnection", None) in (None, unpatched_rospy)


@pytest.mark.parametrize(
    ("name", "requirement"),
    [each for each in REQUIREMENTS if each.values[1].parameters is not None],
)
def test_a_patch_is_left_out_if_a_signature_differs(
    name, requirement, unpatched_rospy, monkeypatch, caplog
):
    monkeypatch.setattr(*owner_of(requirement), lambda some, others: None)

    install()

    assert name in refused(caplog.text)
    assert "has the parameters some, others" in caplog.text


def test_no_patch_is_used_if_patches_are_switched_off(unpatched_rospy, caplog):
    caplog.set_level("INFO")

    calls = install(())

    assert calls == RospyCalls()
    assert rospy.topics.QueuedConnection is unpatched_rospy
    assert "rospy is not patched" in caplog.text
    assert len(caplog.records) == 1


class Connection:
    """A connection to a subscriber, which keeps what it is sent."""

    endpoint_id = "/subscriber"

    def __init__(self) -> None:
        self.received = b""

    def write_data(self, data: bytes) -> None:
        self.received += data

    def fileno(self) -> int:
        return -1

    def close(self) -> None:
        pass


@pytest.fixture
def publisher(monkeypatch) -> Iterator[SimpleNamespace]:
    """A publisher of /clock by rospy itself, and its connection."""
    monkeypatch.setattr(rospy.topics, "is_initialized", lambda: True)
    publisher = rospy.Publisher("/clock", Clock, queue_size=100)
    connection = Connection()
    publisher.impl.connections = [connection]
    yield SimpleNamespace(publisher=publisher, connection=connection)
    publisher.unregister()


def frame(message: Clock) -> bytes:
    """A message as on a TCPROS connection, serialized by ROS's own code."""
    data = serialized(message)
    return LENGTH.pack(len(data)) + data


@pytest.mark.parametrize("is_patched", [False, True])
def test_bytes_are_published_with_and_without_patches(is_patched, publisher, unpatched_rospy):
    calls = install(PATCHES if is_patched else ())
    frames = [frame(Clock(rospy.Time(second))) for second in (1, 2, 3)]

    calls.send_framed(publisher.publisher, frames[0])
    calls.send_framed(publisher.publisher, b"".join(frames[1:]))

    assert publisher.connection.received == b"".join(frames)


def test_the_clock_is_published_without_patches(publisher):
    timekeeper = Timekeeper(0.25)
    clock = ClockPublisher(timekeeper, RospyCalls())
    for _ in range(3):
        timekeeper.step()
        clock.tick()

    clock.flush()

    times = [rospy.Time(0, quarter * 250_000_000) for quarter in range(4)]
    assert publisher.connection.received == b"".join(frame(Clock(time)) for time in times)


def test_a_closed_publisher_is_not_sent_to_without_patches():
    publisher = rospy.Publisher("/topic", Clock, queue_size=1)

    RospyCalls().send_framed(publisher, frame(Clock(rospy.Time(1))))

    publisher.unregister()


def test_topics_are_registered_one_by_one_without_patches(monkeypatch):
    transport = RosTransport()

    with transport.rospy_calls.batch_registration():
        publisher = transport.advertise("/topic", Clock, latch=False, queue_size=1)

    assert ["/topic", Clock._type] in rospy.topics.get_topic_manager().get_publications()
    publisher.close()


def rospy_internals(path: Path) -> List[str]:
    """The uses of rospy in a file that are not its public interface."""
    found = []
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            names = [alias.name for alias in node.names]
        elif isinstance(node, ast.ImportFrom):
            names = [f"{node.module}.{alias.name}" for alias in node.names]
        elif isinstance(node, ast.Attribute):
            names = [ast.unparse(node)]
        else:
            continue
        found += [
            f"{path.name}:{node.lineno}: {name}"
            for name in names
            if name.startswith("rospy.")
            and (name.split(".")[1].startswith("_") or name.split(".")[1] in ROSPY_MODULES)
        ]
    return found


ROSPY_MODULES = ("impl", "core", "topics", "rostime", "client", "service", "names", "msg")


def test_only_the_patches_reach_into_rospy():
    files = [path for path in ROS.glob("*.py") if rospy_internals(path)]

    assert files == []
    assert rospy_internals(ROS / "rospy_patches" / "local_time.py") != []
