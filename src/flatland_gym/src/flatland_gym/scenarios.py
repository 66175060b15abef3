"""The worlds that come with the environments, and the models that episodes move in them."""

import math
from dataclasses import dataclass, field
from pathlib import Path
from typing import Dict, Mapping, Tuple

from flatland_server.config import SCENE_GOALS, find_world

_WORLDS = Path(__file__).resolve().parent / "worlds"


@dataclass(frozen=True)
class Scenario:
    """A world for training.

    Attributes:
        world: its file.
        scatter: name patterns of the models that each episode places at random.
        ends: the `start` and the `goal` of its episodes; otherwise they are drawn.
    """

    world: Path
    scatter: Tuple[str, ...] = ()
    ends: Mapping[str, Tuple[float, ...]] = field(default_factory=dict)


def _scene(name: str, *start: float) -> Scenario:
    """A shipped world with one task."""
    return Scenario(find_world(name), ends={"start": start, "goal": SCENE_GOALS[name]})


SCENARIOS: Dict[str, Scenario] = {
    "empty_room": Scenario(_WORLDS / "empty_room.yaml"),
    "discs": Scenario(_WORLDS / "discs.yaml", ("disc_*",)),
    "corridor": Scenario(_WORLDS / "corridor.yaml", ("person_*",)),
    "doors": Scenario(_WORLDS / "doors.yaml"),
    "corridor_frontal": _scene("corridor_frontal", -6.0, 0.0, 0.0),
    "intersection": _scene("intersection", -6.0, 0.0, 0.0),
    "doorway": _scene("doorway", -4.0, 0.0, 0.0),
    "overtaking": _scene("overtaking", -6.0, 0.0, 0.0),
    "crossing": _scene("crossing", -5.0, 0.0, 0.0),
    "circle_crossing": _scene("circle_crossing", 4.0, 0.0, math.pi),
}
"""By name; "office" is the shipped world of `flatland_server`."""
