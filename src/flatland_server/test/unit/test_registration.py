"""Registration of topics and services, with a fake master that may fail."""

import http.client
from types import SimpleNamespace
from typing import Any, Dict, List, Tuple
from xml.parsers.expat import ExpatError

import pytest
from rospy.impl.registration import Registration
from waiting import wait_until

from flatland_server.ros.rospy_patches import registration as module
from flatland_server.ros.rospy_patches.registration import Registrar

ODOM = ("/odom", "nav_msgs/Odometry", Registration.PUB)
CMD_VEL = ("/cmd_vel", "geometry_msgs/Twist", Registration.SUB)
SPAWN = ("/spawn_model", "rosrpc://here:1", Registration.SRV)
LOGGERS = ("/flatland_server/get_loggers", "rosrpc://here:1", Registration.SRV)
LIMIT = 10.0  # s


class Master:
    """A master that may not answer, and may be restarted."""

    uri = "http://master:1"

    def __init__(self) -> None:
        self.calls: List[List[Any]] = []
        self.known: Dict[Tuple[str, str], str] = {(LOGGERS[2], LOGGERS[0]): LOGGERS[1]}
        self.is_silent = False
        self.refuses: List[str] = []

    def apply(self, changes: List[Any], node_uri: str) -> List[Any]:
        if self.is_silent:
            raise TimeoutError("timed out")
        self.calls.append([(change.is_open, change.name) for change in changes])
        answers = []
        for change in changes:
            if change.is_open:
                self.known[change.kind, change.name] = change.detail
            else:
                del self.known[change.kind, change.name]
            publishers = ["http://joystick:3"] if change.name == "/cmd_vel" else []
            answers.append((int(change.name not in self.refuses), "no", publishers))
        return answers

    def has_service(self, name: str, uri: str) -> bool:
        if self.is_silent:
            raise TimeoutError("timed out")
        return self.known.get((Registration.SRV, name)) == uri


@pytest.fixture(autouse=True)
def short_periods(monkeypatch):
    monkeypatch.setattr(module, "CHECK_PERIOD", 0.02)
    monkeypatch.setattr(module, "RETRY_PERIOD", 0.01)


@pytest.fixture
def master() -> Master:
    return Master()


@pytest.fixture
def updates() -> List[Tuple[str, List[str]]]:
    """The lists of publishers that rospy receives."""
    return []


@pytest.fixture
def registrar(master, updates):
    manager = SimpleNamespace(
        uri="http://here:2", publisher_update=lambda *update: updates.append(update)
    )
    registrar = Registrar(manager, master, is_ending=lambda: False)
    registrar.take_over({(LOGGERS[2], LOGGERS[0]): LOGGERS[1]})
    registrar.start()
    yield registrar
    registrar.stop()


def register(registrar: Registrar, what: Tuple[str, str, str]) -> None:
    registrar.reg_added(*what)
    assert registrar.wait_until_done(LIMIT)


def names(master: Master) -> List[str]:
    return [name for _, name in master.known]


def wait_for(condition) -> None:
    wait_until(condition, "the registrar", interval=0.005)


def test_a_batch_is_registered_in_one_call(master, registrar, updates):
    with registrar.batch():
        for what in (ODOM, CMD_VEL, SPAWN):
            registrar.reg_added(*what)
        assert master.calls == []

    assert registrar.wait_until_done(LIMIT)
    assert master.calls == [[(True, "/odom"), (True, "/cmd_vel"), (True, "/spawn_model")]]
    wait_for(lambda: updates == [("/cmd_vel", ["http://joystick:3"])])


def test_closed_topics_are_unregistered(master, registrar):
    register(registrar, ODOM)
    registrar.reg_removed(*ODOM)

    assert registrar.wait_until_done(LIMIT)
    assert names(master) == [LOGGERS[0]]


def test_topics_closed_in_the_same_batch_are_never_registered(master, registrar):
    with registrar.batch():
        registrar.reg_added(*ODOM)
        registrar.reg_removed(*ODOM)

    assert registrar.wait_until_done(LIMIT)
    assert master.calls == []


def test_a_topic_reopened_in_a_batch_gets_its_publishers(master, registrar, updates):
    register(registrar, CMD_VEL)
    wait_for(lambda: len(updates) == 1)
    with registrar.batch():
        registrar.reg_removed(*CMD_VEL)
        registrar.reg_added(*CMD_VEL)

    wait_for(lambda: updates == [("/cmd_vel", ["http://joystick:3"])] * 2)


def test_a_subscription_opened_again_and_closed_is_unregistered(master, registrar):
    register(registrar, CMD_VEL)
    with registrar.batch():
        registrar.reg_removed(*CMD_VEL)
        registrar.reg_added(*CMD_VEL)
        registrar.reg_removed(*CMD_VEL)

    assert registrar.wait_until_done(LIMIT)
    assert names(master) == [LOGGERS[0]]


def test_many_are_registered_in_several_calls(master, registrar, monkeypatch):
    monkeypatch.setattr(module, "_BATCH", 4)
    with registrar.batch():
        for number in range(10):
            registrar.reg_added(f"/topic{number}", "std_msgs/Bool", Registration.PUB)

    assert registrar.wait_until_done(LIMIT)
    assert [len(call) for call in master.calls] == [4, 4, 2]


def test_a_silent_master_holds_up_nothing_and_is_called_later(master, registrar, caplog):
    master.is_silent = True
    registrar.reg_added(*ODOM)

    assert not registrar.wait_until_done(LIMIT)  # returns as soon as the call fails
    assert caplog.text.count("does not answer") == 1
    registrar.reg_added(*CMD_VEL)
    registrar.reg_removed(*ODOM)
    master.is_silent = False

    wait_for(lambda: "/cmd_vel" in names(master))
    assert "/odom" not in names(master)


def test_an_answer_that_breaks_off_is_asked_for_again(master, registrar, monkeypatch):
    apply, breaks = master.apply, [http.client.IncompleteRead(b"<"), ExpatError("no element found")]

    def break_off(*arguments):
        if breaks:
            raise breaks.pop()
        return apply(*arguments)

    monkeypatch.setattr(master, "apply", break_off)
    registrar.reg_added(*ODOM)

    wait_for(lambda: "/odom" in names(master))


def test_everything_is_registered_again_with_a_restarted_master(master, registrar, caplog):
    register(registrar, ODOM)
    master.known.clear()

    wait_for(lambda: sorted(names(master)) == sorted([LOGGERS[0], "/odom"]))
    assert "the master was restarted" in caplog.text


def test_a_master_may_restart_during_a_registration(master, registrar):
    register(registrar, ODOM)
    master.is_silent = True
    registrar.reg_added(*CMD_VEL)
    assert not registrar.wait_until_done(LIMIT)
    master.known.clear()
    master.is_silent = False

    wait_for(lambda: set(names(master)) == {LOGGERS[0], "/odom", "/cmd_vel"})


def test_a_refusal_is_reported_once(master, registrar, caplog):
    master.refuses.append("/odom")
    register(registrar, ODOM)
    wait_for(lambda: "the master refuses /odom: no" in caplog.text)
    assert len(master.calls) == 1


def test_closed_topics_are_unregistered_while_rospy_shuts_down(master, monkeypatch):
    monkeypatch.setattr(module, "_BATCH", 4)
    registrar = Registrar(SimpleNamespace(uri="http://here:2"), master, is_ending=lambda: True)
    topics = [(f"/topic{number}", "std_msgs/Bool", Registration.PUB) for number in range(10)]
    master.known.update({(kind, name): detail for name, detail, kind in topics})
    registrar.take_over(dict(master.known))
    registrar.start()
    for topic in topics:
        registrar.reg_removed(*topic)
    registrar.stop()

    assert names(master) == [LOGGERS[0]]


def test_after_its_end_the_master_is_not_called(master, registrar, monkeypatch):
    registrar.reg_added(*ODOM)
    registrar.stop()
    calls = len(master.calls)
    assert "/odom" in names(master)
    monkeypatch.setattr(module, "_END_LIMIT", 0.0)  # it ends once more after the test

    registrar.reg_added(*CMD_VEL)
    master.known.clear()

    assert not registrar.wait_until_done(0.1)
    assert len(master.calls) == calls
