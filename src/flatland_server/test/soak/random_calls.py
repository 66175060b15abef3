"""Random service calls of several clients at once, against a model of the world in Python.

Each client has names of its own: the answers to spawning and deleting these are known. All clients
share other names: for these it is known that spawns and deletions alternate.
"""

import math
import random
import socket
import threading
from collections import Counter
from pathlib import Path
from typing import Any, Callable, Dict, List, Set
from typing import Counter as CounterType

import tcpros_client
from flatland_msgs.msg import DebugTopicList, Model, SimulationState
from flatland_msgs.srv import (
    ChangeRate,
    DeleteModel,
    DeleteModels,
    GetModelMarkers,
    MoveModel,
    Seek,
    SpawnModel,
    SpawnModels,
)
from geometry_msgs.msg import Pose2D
from running_server import NODE, ROBOT, WORLDS, Master, Server
from soak.findings import Findings
from std_srvs.srv import Empty, Trigger
from waiting import wait_until

OWN, SHARED = 4, 3  # names of each client, and of all
BOX = WORLDS / "office" / "box.model.yaml"
HERE = Path(__file__).resolve().parent
WRONG_FILES = (
    *("", "/", "no.yaml", "/dev/null", str(WORLDS), str(WORLDS / "test_room" / "world.yaml")),
    *(str(HERE.parent / "worlds" / f"{n}.model.yaml") for n in ("misspelt", "fails_to_start")),
    *("x" * 5000, "\x00", str(WORLDS / "office" / "office.png")),
)
WRONG_TEXTS = ("", "bodies: [", "[]", "bodies: $include /etc/passwd", "\x00", "a: &a [*a]")
WRONG_NAMES = ("", " ", "a b", "/", "//a", "a/", "-", "ü", "a\nb", "\x00", "$", "a" * 10 + "!")
WRONG_NAMESPACES = ("a b", "1st", "-", "ü", "a//b", "_a", "{}")
NUMBERS = (math.nan, math.inf, -math.inf, 1e300, -1e9)
RATES = {0.5: True, 1.0: True, 3.0: True, math.inf: True, 0.0: False, -1.0: False, math.nan: False}
EXCEPTIONS = tuple(
    f"{name}: "
    for name in ("ModelError", "YamlError", "PluginError", "LayerError", "UsageError", "ValueError")
)


class Balance:
    """Successful spawns minus successful deletions, by name; there is a model while it is 1."""

    def __init__(self) -> None:
        self._balance: CounterType[str] = Counter()
        self._lock = threading.Lock()

    def add(self, name: str, change: int) -> None:
        with self._lock:
            self._balance[name] += change

    def names(self, findings: Findings) -> Set[str]:
        """The names of the models that must exist."""
        for name, balance in self._balance.items():
            findings.expect(balance in (0, 1), f"{name} is there {balance} times")
        return {name for name, balance in self._balance.items() if balance > 0}


class Client:
    """Calls services at random, one after the other."""

    def __init__(
        self, server: Server, number: int, seed: int, balance: Balance, findings: Findings
    ) -> None:
        self._server = server
        self._rng = random.Random(f"calls {seed} {number}")
        self._what = f"seed {seed}, client {number}"
        self._own = [f"own{number}_{index}" for index in range(OWN)]
        self._present: Set[str] = set()  # of the own names
        self._balance = balance
        self._findings = findings

    def run(self, calls: int) -> None:
        """Makes some calls; each must be answered."""
        actions: List[Callable[[], None]] = [
            self._spawn, self._spawn, self._delete, self._delete, self._move, self._move,
            self._spawn_wrongly, self._delete_unknown, self._change_pause, self._change_rate,
            self._get_markers, self._hang_up, self._spawn_several, self._delete_several,
            self._step_world, self._seek_wrongly,
        ]  # fmt: skip
        for _ in range(calls):
            action = self._rng.choice(actions)
            self._findings.counts["calls"] += 1
            try:
                action()
            except (OSError, UnicodeError) as error:
                name = action.__name__.strip("_")
                self._findings.counts["unanswered"] += 1
                self._findings.expect(False, f"{self._what}: {name} was not answered: {error!r}")

    def _check(self, answer: Any, is_expected: bool, what: str) -> None:
        """Compares an answer's success with what is expected, and looks at its message."""
        is_right = answer.success == is_expected
        self._findings.expect(is_right, f"{self._what}: {what}: {answer.message!r}")
        if not answer.success:
            is_named = answer.message.startswith(EXCEPTIONS)
            self._findings.expect(is_named, f"{self._what}: {what}: error {answer.message!r}")

    def _pose(self, is_valid: bool = True) -> Pose2D:
        values = [self._rng.uniform(-4, 4), self._rng.uniform(-2, 2), self._rng.uniform(-9, 9)]
        if not is_valid:
            values[self._rng.randrange(3)] = self._rng.choice(NUMBERS[:3])
        return Pose2D(*values)

    def _spawn(self) -> None:
        name = self._rng.choice([*self._own, *self._own, *SHARED_NAMES])
        path = self._rng.choice([ROBOT, BOX])
        service, source = self._rng.choice(
            [("/spawn_model", str(path)), ("/spawn_model_from_string", path.read_text())]
        )
        answer = self._server.call(
            service, SpawnModel, yaml_path=source, name=name, ns=name, pose=self._pose()
        )
        if name in self._own:
            self._check(answer, name not in self._present, f"spawn {name}")
            self._present.add(name)
        else:
            self._check(answer, answer.success, f"spawn {name}")
        if answer.success:
            self._balance.add(name, 1)

    def _delete(self) -> None:
        name = self._rng.choice([*self._own, *self._own, *SHARED_NAMES])
        answer = self._server.call("/delete_model", DeleteModel, name=name)
        if name in self._own:
            self._check(answer, name in self._present, f"delete {name}")
            self._present.discard(name)
        else:
            self._check(answer, answer.success, f"delete {name}")
        if answer.success:
            self._balance.add(name, -1)

    def _some_names(self) -> List[str]:
        return [self._rng.choice(self._own) for _ in range(self._rng.randrange(4))]

    def _spawn_several(self) -> None:
        names = self._some_names()
        models = [Model(str(BOX), name, name, self._pose()) for name in names]
        answer = self._server.call("/spawn_models", SpawnModels, models=models)
        are_new = len(set(names)) == len(names) and not self._present & set(names)
        self._check(answer, are_new, f"spawn {names}")
        if answer.success:
            self._present |= set(names)
            for name in names:
                self._balance.add(name, 1)

    def _delete_several(self) -> None:
        names = self._some_names()
        answer = self._server.call("/delete_models", DeleteModels, name=names)
        are_there = len(set(names)) == len(names) and self._present >= set(names)
        self._check(answer, are_there, f"delete {names}")
        if answer.success:
            self._present -= set(names)
            for name in names:
                self._balance.add(name, -1)

    def _step_world(self) -> None:
        """Another client may resume the simulation meanwhile, or make steps."""
        try:
            self._server.call("/step_world", Empty)
        except ConnectionError as error:
            self._findings.expect("FlatlandError: " in str(error), f"{self._what}: {error!r}")

    def _move(self) -> None:
        name, is_valid = self._rng.choice(self._own), self._rng.random() < 0.8
        pose = self._pose(is_valid)
        answer = self._server.call("/move_model", MoveModel, name=name, pose=pose)
        self._check(answer, is_valid and name in self._present, f"move {name} to {pose}")

    def _spawn_wrongly(self) -> None:
        request = {"yaml_path": str(ROBOT), "name": "wrong", "ns": "wrong", "pose": self._pose()}
        key = self._rng.choice(sorted(request))
        wrong: Dict[str, Callable[[], Any]] = {
            "yaml_path": lambda: self._rng.choice(WRONG_FILES),
            "name": lambda: self._rng.choice(WRONG_NAMES),
            "ns": lambda: self._rng.choice(WRONG_NAMESPACES),
            "pose": lambda: self._pose(is_valid=False),
        }
        request[key] = wrong[key]()
        service = "/spawn_model"
        if key == "yaml_path" and self._rng.random() < 0.5:
            service, request[key] = "/spawn_model_from_string", self._rng.choice(WRONG_TEXTS)
        answer = self._server.call(service, SpawnModel, **request)
        self._check(answer, False, f"spawn with {key} {str(request[key])[:80]!r}")

    def _seek_wrongly(self) -> None:
        time = self._rng.choice(NUMBERS)
        answer = self._server.call("/seek", Seek, time=time)
        self._check(answer, False, f"seek {time}")

    def _delete_unknown(self) -> None:
        name = self._rng.choice(["unknown", *WRONG_NAMES])
        self._check(self._server.call("/delete_model", DeleteModel, name=name), False, "delete")

    def _change_pause(self) -> None:
        self._server.call(self._rng.choice(["/pause", "/resume", "/toggle_pause"]), Empty)

    def _change_rate(self) -> None:
        rate = self._rng.choice(list(RATES))
        answer = self._server.call("/change_rate", ChangeRate, rate=rate)
        self._check(answer, RATES[rate], f"rate {rate}")

    def _get_markers(self) -> None:
        path = self._rng.choice([str(ROBOT), str(BOX), *WRONG_FILES])
        answer = self._server.call("/get_model_markers", GetModelMarkers, yaml_path=path)
        # A model that fails to start can be shown.
        is_shown = path not in WRONG_FILES or "fails_to_start" in path or "misspelt" in path
        self._check(answer, is_shown, f"markers of {path[:80]!r}")

    def _hang_up(self) -> None:
        """Closes a connection within a request, or before its answer."""
        name = "/get_model_markers"
        data = tcpros_client.request_bytes(GetModelMarkers, yaml_path=str(ROBOT))
        address = self._server.service_address()
        with tcpros_client.open_connection(address, service=name) as connection:
            connection.sendall(data[: self._rng.randrange(len(data) + 1)])
            if self._rng.random() < 0.5:
                connection.shutdown(socket.SHUT_RDWR)


SHARED_NAMES = [f"shared{index}" for index in range(SHARED)]


def call_at_random(
    server: Server, master: Master, seed: int, clients: int, calls: int, findings: Findings
) -> None:
    """Has clients make `calls` calls each, and compares the world with the expected one.

    The world is empty but for its own models before, and is so again at the end.
    """
    before = models_shown(server)
    balance = Balance()
    threads = [
        threading.Thread(
            target=Client(server, number, seed, balance, findings).run, args=(calls,), daemon=True
        )
        for number in range(clients)
    ]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    server.call("/change_rate", ChangeRate, rate=1.0)
    check_pause(server, findings)

    names = balance.names(findings)
    with findings.part("comparisons of the world"):
        wait_until(lambda: models_shown(server) == before | names, f"the models to be {names}")
        wait_until(lambda: scanning(master) <= names, f"the topics of {names}")
        undo_and_redo(server)
        wait_until(lambda: models_shown(server) == before | names, f"{names} to be there again")
        for name in names:
            findings.expect(server.delete(name).success, f"seed {seed}: {name} is not there")
        wait_until(lambda: models_shown(server) == before, "all models to be deleted")
        wait_until(lambda: master.topics() == server.topics, "only topics of the start")
    findings.expect("Traceback" not in server.log, f"seed {seed}: a traceback in the log")


def undo_and_redo(server: Server) -> None:
    """Undoes all edits that can be undone, and does as many again."""
    for service in ("/undo", "/redo"):
        while "nothing to" not in server.call(service, Trigger).message:
            pass


def check_pause(server: Server, findings: Findings) -> None:
    """Pauses and resumes: the state follows."""
    for name, is_paused in (("/pause", True), ("/toggle_pause", False), ("/resume", False)):
        server.call(name, Empty)
        with findings.part("comparisons of the state"):
            wait_until(lambda e=is_paused: state(server).paused == e, f"{name} to be seen")


def state(server: Server) -> SimulationState:
    """The latched state of the simulation."""
    with tcpros_client.subscribe(server.uri, f"{NODE}/state", SimulationState) as connection:
        return tcpros_client.next_message(connection, SimulationState)


def models_shown(server: Server) -> Set[str]:
    """The models in the latched list of marker topics."""
    topic = f"{NODE}/debug/topics"
    with tcpros_client.subscribe(server.uri, topic, DebugTopicList) as connection:
        topics = tcpros_client.next_message(connection, DebugTopicList).topics
    return {name[len("model/") :] for name in topics if name.startswith("model/")}


def scanning(master: Master) -> Set[str]:
    """The spawned models with topics of scans at the master."""
    found = {topic.split("/")[1] for topic in master.topics() if topic.endswith("/scan")}
    return {name for name in found if name.startswith(("own", "shared"))}
