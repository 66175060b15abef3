"""The worlds that come with the environments, and the models that episodes move in them."""

from dataclasses import dataclass
from pathlib import Path
from typing import Dict, Tuple

_WORLDS = Path(__file__).resolve().parent / "worlds"


@dataclass(frozen=True)
class Scenario:
    """A world for training.

    Attributes:
        world: its file.
        scatter: name patterns of the models that each episode places at random.
    """

    world: Path
    scatter: Tuple[str, ...] = ()


SCENARIOS: Dict[str, Scenario] = {
    "empty_room": Scenario(_WORLDS / "empty_room.yaml"),
    "discs": Scenario(_WORLDS / "discs.yaml", ("disc_*",)),
    "corridor": Scenario(_WORLDS / "corridor.yaml", ("person_*",)),
    "doors": Scenario(_WORLDS / "doors.yaml"),
}
"""By name; "office" is the shipped world of `flatland_server`."""
