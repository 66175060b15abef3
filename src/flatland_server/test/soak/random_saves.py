"""Random changes of a world that are saved in its file: it loads, and has the world's models."""

import random
import shutil
from pathlib import Path
from typing import Any, Callable, Dict, List, Set

from flatland_msgs.srv import (
    DeleteModel,
    LoadState,
    MoveModel,
    OpenWorld,
    Reset,
    SaveState,
    SaveWorld,
    SpawnModel,
)
from geometry_msgs.msg import Pose2D
from running_server import WORLDS, Server
from soak.findings import Findings
from soak.random_calls import BOX, models_shown
from std_srvs.srv import Trigger
from waiting import wait_until

from flatland_server.exceptions import FlatlandError
from flatland_server.simulation.world_config import WorldConfig

NAMES = [f"saved{index}" for index in range(5)]
WORLD = WORLDS / "test_room" / "world.yaml"


def save_at_random(server: Server, folder: Path, seed: int, count: int, findings: Findings) -> None:
    """Opens a copy of the test room, makes calls at random, and compares the file with the world.

    Args:
        server: server with the test room, without other models, at the beginning and at the end.
        folder: folder for the files, which is created.
        seed: the calls' seed.
        count: number of calls.
        findings: gets the counts and violations.
    """
    shutil.copytree(WORLD.parent, folder / "room")
    shutil.copytree(WORLDS / "office", folder / "office")
    foreign = folder / "mkdocs.yml"
    foreign.write_text("plugins:\n- search\nlayers: []\n")
    before = foreign.read_bytes()
    before_models = models_shown(server)
    world = folder / "room" / "world.yaml"
    findings.expect(server.call("/open_world", OpenWorld, path=str(world)).success, "open_world")
    _Saver(server, world, f"seed {seed}", random.Random(f"saves {seed}"), findings).run(count)
    refused = server.call("/save_world", SaveWorld, path=str(foreign))
    findings.expect(
        not refused.success and foreign.read_bytes() == before, f"seed {seed}: {foreign}"
    )
    findings.expect(server.call("/open_world", OpenWorld, path=str(WORLD)).success, "open_world")
    wait_until(lambda: models_shown(server) == before_models, "the models of the test room")


class _Saver:
    """A client that knows the models of the world, and of its file."""

    def __init__(
        self, server: Server, world: Path, what: str, rng: random.Random, findings: Findings
    ) -> None:
        self._server, self._world, self._what = server, world, what
        self._rng, self._findings = rng, findings
        self._present = self._filed = {"turtlebot"}
        self._states: Dict[str, Set[str]] = {}

    def run(self, count: int) -> None:
        actions: List[Callable[[], None]] = [
            *(self._spawn, self._spawn, self._delete, self._move, self._save, self._save_state),
            *(self._load_state, self._reset, self._reload),
        ]
        for _ in range(count):
            self._findings.counts["calls before saves"] += 1
            self._rng.choice(actions)()
        self._save()

    def _call(self, what: str, service: Any, is_expected: bool = True, **request: Any) -> bool:
        answer = self._server.call(what, service, **request)
        self._findings.expect(
            answer.success == is_expected, f"{self._what}: {what} {request}: {answer.message!r}"
        )
        return bool(answer.success)

    def _pose(self) -> Pose2D:
        return Pose2D(*(self._rng.uniform(-2, 2) for _ in range(3)))

    def _spawn(self) -> None:
        name = self._rng.choice(NAMES)
        is_new = name not in self._present
        request = {"yaml_path": str(BOX), "name": name, "ns": f"~{name}", "pose": self._pose()}
        if self._call("/spawn_model", SpawnModel, is_new, **request):
            self._present = self._present | {name}

    def _delete(self) -> None:
        name = self._rng.choice([*NAMES, "turtlebot"])
        if self._call("/delete_model", DeleteModel, name in self._present, name=name):
            self._present = self._present - {name}

    def _move(self) -> None:
        name = self._rng.choice([*NAMES, "turtlebot"])
        self._call("/move_model", MoveModel, name in self._present, name=name, pose=self._pose())

    def _save(self) -> None:
        if not self._call("/save_world", SaveWorld, path=""):
            return
        self._filed = self._present
        self._findings.counts["saved worlds"] += 1
        try:
            found = {entry.name for entry in WorldConfig.from_file(self._world).models}
        except FlatlandError as error:
            self._findings.expect(False, f"{self._what}: a saved world: {error}")
            return
        self._findings.expect(found == self._present, f"{self._what}: saved {found}")

    def _save_state(self) -> None:
        path = str(self._world.with_name(self._rng.choice("12")))
        if self._call("/save_state", SaveState, path=path):
            self._states[path] = self._present

    def _load_state(self) -> None:
        """It is refused if a model that came with the file is not in it any more."""
        if not self._states:
            return
        path = self._rng.choice(sorted(self._states))
        answer = self._server.call("/load_state", LoadState, path=path)
        if answer.success:
            self._present = self._states[path]
        else:
            is_known = "the state is of another world" in answer.message
            self._findings.expect(is_known, f"{self._what}: load_state: {answer.message!r}")

    def _reset(self) -> None:
        if self._call("/reset", Reset):
            self._present = self._filed

    def _reload(self) -> None:
        if self._call("/reload_world", Trigger):
            self._present = self._filed
