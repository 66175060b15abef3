"""Shared by the tests of Crowd: people in the `town` of conftest.py, and their positions."""

from typing import Any, Dict, Tuple

import numpy as np

SPEED, RADIUS, TAU = 1.34, 0.25, 0.5
UPDATE = 0.05
CALM = "force: {noise: 0}"
TOWARDS_EACH_OTHER = (
    "pose: [-4, 0, 0], goals: [[4, 0], [9, 0]]",
    "pose: [4, 0, 3.14], goals: [[-4, 0], [-9, 0]]",
)
ROOM = ("-5 -3 5 -3", "5 -3 5 3", "5 3 -5 3", "-5 3 -5 -3")


def two_crowds(town, files, keys: str) -> Any:
    """Two people of two crowds, "people" and "others", on the way towards each other."""
    town(TOWARDS_EACH_OTHER[0], keys=keys)
    second = f"{{type: Crowd, name: others, {keys}, pedestrians: [{{{TOWARDS_EACH_OTHER[1]}}}]}}"
    return files.load(f"{(files.folder / 'world.yaml').read_text()}\n  - {second}\n")


def least_gap(path: np.ndarray) -> float:
    """The least distance between any two people on their paths, between their bodies [m]."""
    offsets = path[:, :, np.newaxis] - path[:, np.newaxis]
    apart = np.linalg.norm(offsets, axis=-1) + np.where(np.eye(path.shape[1]), np.inf, 0.0)
    return float(apart.min()) - 2 * RADIUS


def robot(files, *plugins: str, pose: str = "[0, 0, 0]", **options: Any) -> Dict[str, str]:
    """A disc of 0.2 m, by default, for `town`."""
    return {"robot": f"model: {files.model('robot', *plugins, **options)}, pose: {pose}"}


def position(town: Any, name: str = "people_0") -> Tuple[float, float]:
    return tuple(town.model(name).pose[:2])


def velocity(town: Any, name: str = "people_0") -> Tuple[float, float]:
    return tuple(town.model(name).base.physics_body.velocity[:2])


def walk(town: Any, seconds: float, *names: str) -> np.ndarray:
    """Runs for a time [s]; returns people's positions, shape (steps, persons, 2)."""
    path = []
    for _ in range(round(seconds / 0.005)):
        town.run()
        path.append([position(town, name) for name in names or ("people_0",)])
    return np.array(path)
