"""Spoilt files: reading one gives a world or an error with its file and line, in bounded time.

A spawn that fails leaves the world as it was; one that succeeds can be undone.
"""

import random
import time
import traceback
from pathlib import Path
from typing import Any, Dict, Iterable, List

from soak.corpus import Corpus
from soak.findings import Findings
from soak.mutations import Mutator
from soak.random_messages import unusual_poses

from flatland_server import FlatlandError, ModelError, PluginLoader, Pose, World, YamlError
from flatland_server.testing import Harness

READ_LIMIT = 10.0  # s; an expression may take one, and the machine may be busy
STEPS = 3


class RandomFiles:
    """Spoils the files of a corpus, one at a time, and loads what depends on them.

    Args:
        folder: an empty folder.
        seed: the changes' seed.
        findings: to which counts and violations are added.
    """

    def __init__(self, folder: Path, seed: int, findings: Findings) -> None:
        self._seed = seed
        self._rng = random.Random(f"files {seed}")
        self._mutator = Mutator(self._rng)
        self._corpus = Corpus.copy_to(folder)
        self._findings = findings
        self._loader = PluginLoader()
        self.world = World.from_file(folder / "plugins" / "world.yaml", loader=self._loader)
        self._simulation = Harness(self.world, allow_failures=True)

    def run(self, count: int, seconds: float) -> None:
        """Reads `count` spoilt files, or as many as can be read in a time [s]."""
        end = time.monotonic() + seconds
        for number in range(count):
            if time.monotonic() > end:
                break
            self._read_spoilt_file(f"seed {self._seed}, file {number}")
        self.world.close()

    def _read_spoilt_file(self, what: str) -> None:
        corpus = self._corpus
        kind = self._rng.choice(["model", "model", "model", "world", "part"])
        path = self._rng.choice(getattr(corpus, f"{kind}s"))
        self._mutator.spoil(path)
        begin = time.monotonic()
        try:
            if kind == "model":
                self._spawn(path)
            elif kind == "world":
                self._load(path)
            else:
                self._load(self._rng.choice(_near(path, corpus.worlds)))
            self._findings.counts["spoilt files accepted"] += 1
        except FlatlandError as error:
            self._findings.counts["spoilt files refused"] += 1
            self._check_error(error, what)
        except Exception:
            self._findings.expect(False, f"{what}, {path.name}: {traceback.format_exc()}")
        seconds = time.monotonic() - begin
        self._findings.expect(seconds < READ_LIMIT, f"{what}, {path.name}: took {seconds:.1f} s")
        corpus.restore(path)

    def _spawn(self, path: Path) -> None:
        before = snapshot(self.world)
        try:
            self.world.spawn_model(path, "spoilt", "ns", Pose(100.0, 100.0, 0.5))
            self._run(self._simulation)
        finally:
            if "spoilt" in self.world.models:
                self.world.delete_model("spoilt")
            after = snapshot(self.world)
            changes = [key for key in before if before[key] != after[key]]
            self._findings.expect(not changes, f"{path.name} has left behind: {changes}")

    def _load(self, path: Path) -> None:
        world = World.from_file(path, loader=self._loader, seed=self._rng.randrange(100))
        try:
            self._run(Harness(world, allow_failures=True))
        finally:
            world.close()

    def _run(self, simulation: Harness) -> None:
        simulation.run(STEPS * simulation.timekeeper.step_size)
        poses = unusual_poses(simulation.world)
        self._findings.expect(not poses, f"poses {poses[:2]}")
        for failure in simulation.world.plugin_failures:
            # A plugin of the examples spawns models by names that it was given.
            is_refusal = "ModelError" in failure.reason
            self._findings.expect(is_refusal, f"{failure.label} failed in {failure.reason}")

    def _check_error(self, error: FlatlandError, what: str) -> None:
        if isinstance(error, ModelError) and "does not fit into the world" in str(error):
            return  # a matter of the file and of the pose at which it is spawned
        if not self._findings.expect(isinstance(error, YamlError), f"{what}: {error!r}"):
            return
        assert isinstance(error, YamlError)
        for problem in error.problems:
            has_place = problem.line is not None or is_of_a_whole_file(problem.message)
            self._findings.expect(has_place, f"{what}: no line in {str(problem)[:300]}")


def is_of_a_whole_file(message: str) -> bool:
    """True if a problem concerns a file as a whole, so that it has no line."""
    beginnings = (
        "cannot be read", "is not UTF-8", "is not valid YAML", "is nested too deeply",
        "expected a map, found an empty file", "is not an image", "expected walls",
    )  # fmt: skip
    return message.startswith(beginnings)


def snapshot(world: World) -> Dict[str, Any]:
    """The state that a failed spawn must not change."""
    transport: Any = world.transport
    return {
        "models": sorted(world.models),
        "topics": sorted(transport.topics),
        "subscribed": sorted(transport.subscribed),
        "bodies": world.physics.body_count,
        "joints": world.physics.joint_count,
        "entities": len(list(world.entities)),
        "frames": sorted(world.odometry_frames),
        "plugins": world.plugin_count,
    }


def _near(path: Path, worlds: Iterable[Path]) -> List[Path]:
    """The worlds in the folder of a file or above it; else all."""
    near = [world for world in worlds if world.parent in path.parents]
    return near or list(worlds)
