"""Registering many topics in one call, with a fake master that notes the calls."""

import xmlrpc.client
from types import SimpleNamespace
from typing import Any, List, Tuple

import pytest
import rospy
from rospy.impl import registration
from rospy.impl.registration import Registration

from flatland_server.exceptions import FlatlandError
from flatland_server.ros.rospy_patches import batch_registration as module
from flatland_server.ros.rospy_patches.batch_registration import batch_registration

ODOM = ("/odom", "nav_msgs/Odometry")
CMD_VEL = ("/cmd_vel", "geometry_msgs/Twist")
SPAWN = ("/spawn_model", "rosrpc://here:1")
NODE, URI = "/flatland_server", "http://here:2"


class Manager:
    """A fake of rospy's RegManager, which registers each topic by itself."""

    master_uri, uri = "http://master:1", URI

    def __init__(self) -> None:
        self.calls: List[Tuple[Any, ...]] = []
        self.updates: List[Tuple[str, List[str]]] = []

    def reg_added(self, *what: str) -> None:
        self.calls.append(("added", *what))

    def reg_removed(self, *what: str) -> None:
        self.calls.append(("removed", *what))

    def publisher_update(self, name: str, publishers: List[str]) -> None:
        self.updates.append((name, publishers))


class Master:
    """Answers a multicall as the master does."""

    def __init__(self) -> None:
        self.batches: List[List[Tuple[Any, ...]]] = []
        self.refuses: List[str] = []
        self.system = SimpleNamespace(multicall=self._multicall)

    def _multicall(self, calls: Any) -> List[Any]:
        self.batches.append([(call["methodName"], *call["params"]) for call in calls])
        return [[self._answer(call)] for call in calls]

    def _answer(self, call: Any) -> List[Any]:
        name = call["params"][1]
        publishers = ["http://joystick:3"] if name == "/cmd_vel" else []
        return [int(name not in self.refuses), "", publishers]


@pytest.fixture
def master(monkeypatch) -> Master:
    master = Master()
    monkeypatch.setattr(rospy.core, "xmlrpcapi", lambda uri: master)
    monkeypatch.setattr(rospy, "get_caller_id", lambda: NODE)
    return master


@pytest.fixture
def listeners(monkeypatch) -> registration.RegistrationListeners:
    listeners = registration.RegistrationListeners()
    monkeypatch.setattr(module, "get_registration_listeners", lambda: listeners)
    return listeners


@pytest.fixture
def manager(listeners) -> Manager:
    manager = Manager()
    listeners.listeners.append(manager)
    return manager


def open_all(listeners: registration.RegistrationListeners) -> None:
    listeners.notify_added(*ODOM, Registration.PUB)
    listeners.notify_added(*CMD_VEL, Registration.SUB)
    listeners.notify_added(*SPAWN, Registration.SRV)


def test_everything_is_registered_in_one_call(master, manager, listeners):
    with batch_registration():
        open_all(listeners)
        assert master.batches == []

    assert master.batches == [
        [
            ("registerPublisher", NODE, *ODOM, URI),
            ("registerSubscriber", NODE, *CMD_VEL, URI),
            ("registerService", NODE, *SPAWN, URI),
        ]
    ]
    assert manager.updates == [("/cmd_vel", ["http://joystick:3"])]
    assert manager.calls == []


def test_before_and_after_it_each_topic_is_registered_by_itself(master, manager, listeners):
    with batch_registration():
        pass
    listeners.notify_added(*ODOM, Registration.PUB)

    assert manager.calls == [("added", *ODOM, Registration.PUB)]


def test_what_is_closed_again_is_never_registered(master, manager, listeners):
    with batch_registration():
        open_all(listeners)
        listeners.notify_removed(*ODOM, Registration.PUB)

    assert "/odom" not in [call[2] for call in master.batches[0]]
    assert manager.calls == []


def test_what_was_open_before_can_be_closed(master, manager, listeners):
    with batch_registration():
        listeners.notify_removed("/clock", "rosgraph_msgs/Clock", Registration.SUB)

    assert manager.calls == [("removed", "/clock", "rosgraph_msgs/Clock", Registration.SUB)]


@pytest.mark.parametrize("failure", [ConnectionRefusedError(), xmlrpc.client.Fault(1, "what?")])
def test_a_call_that_fails_is_left_to_rospy(failure, master, manager, listeners):
    def fail(calls: Any) -> None:
        raise failure

    master.system.multicall = fail
    with batch_registration():
        listeners.notify_added(*ODOM, Registration.PUB)

    assert manager.calls == [("added", *ODOM, Registration.PUB)]


def test_a_registration_that_the_master_refuses_is_left_to_rospy(master, manager, listeners):
    master.refuses.append("/odom")

    with batch_registration():
        open_all(listeners)

    assert manager.calls == [("added", *ODOM, Registration.PUB)]


def test_a_world_that_does_not_load_is_not_registered(master, manager, listeners):
    def fail_to_load() -> None:
        with batch_registration():
            open_all(listeners)
            raise FlatlandError("a wall is missing")

    with pytest.raises(FlatlandError):
        fail_to_load()

    assert master.batches == []
    assert listeners.listeners == [manager]
