"""The content of a saved state of a world, as plain data.

It does not include the world's files: loading a state rebuilds the world from its files, repeats
additions and deletions made since, and then sets the values that have changed.
"""

from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any, Dict, List, Optional

from flatland_server import plain_data
from flatland_server.exceptions import StateError
from flatland_server.simulation.plugin_state import PluginState

_FORMAT = 1
_FORMAT_KEY = "flatland_state"


@dataclass(frozen=True)
class ModelState:
    """An existing model, and how to make it again."""

    name: str
    order: Optional[int]
    """Its index among all additions since the world was made; None: it came with the world."""
    namespace: str
    path: str
    """The path of its file, if it was added later."""
    pose: List[float]
    """The pose with which it was added."""
    move_revision: int
    """See `Model.move_revision`."""
    content: Optional[Dict[str, Any]] = None
    """The plain data that it was read from, if not a file; see `ModelConfig.content`."""


@dataclass(frozen=True)
class WallsState:
    """Walls that were added since the world was made."""

    order: int
    layer: int
    segments: Any


@dataclass(frozen=True)
class WorldState:
    """The state of a world."""

    world: str
    """The path of its file, for messages."""
    seed: int
    nanoseconds: int
    """Simulated time."""
    wall_counts: Dict[str, int]
    """The number of walls of each layer when the world was made, to recognise another map."""
    models: List[ModelState]
    walls: List[WallsState]
    plugins: List[PluginState]
    physics: bytes
    """See `_core.World.save_state`."""

    def dumps(self) -> bytes:
        """The state as bytes; see `plain_data`."""
        return plain_data.dumps({_FORMAT_KEY: _FORMAT, **asdict(self)})

    @classmethod
    def loads(cls, data: bytes) -> "WorldState":
        """A state out of bytes.

        Raises:
            StateError: this is not the state of a world, or damaged.
        """
        try:
            content = plain_data.loads(data)
        except ValueError:
            content = None
        if not isinstance(content, dict) or _FORMAT_KEY not in content:
            raise StateError("expected the state of a world, found something else")
        found = content.pop(_FORMAT_KEY)
        if found != _FORMAT:
            raise StateError(f"expected a state of format {_FORMAT}, found format {found}")
        try:
            content["models"] = [ModelState(**each) for each in content["models"]]
            content["walls"] = [WallsState(**each) for each in content["walls"]]
            content["plugins"] = [PluginState(**each) for each in content["plugins"]]
            state = cls(**content)
        except (KeyError, TypeError) as error:
            raise StateError(f"the state is damaged: {error}") from None
        kinds = {"world": str, "seed": int, "nanoseconds": int, "wall_counts": dict}
        for name, kind in {**kinds, "physics": bytes}.items():
            if not isinstance(getattr(state, name), kind):
                raise StateError(f'the state is damaged: "{name}" is no {kind.__name__}')
        return state


def read_state(path: Path) -> bytes:
    """A state file's content.

    Raises:
        StateError: it cannot be read.
    """
    try:
        return path.read_bytes()
    except OSError as error:
        raise StateError(f"cannot read {path}: {error.strerror}") from None


def write_state(path: Path, state: bytes) -> None:
    """Writes a state file: completely, or not at all.

    Raises:
        StateError: it cannot be written.
    """
    partial = path.with_name(f"{path.name}.partial")
    try:
        partial.write_bytes(state)
        partial.replace(path)
    except OSError as error:
        raise StateError(f"cannot write {path}: {error.strerror}") from None
