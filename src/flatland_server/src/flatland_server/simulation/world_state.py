"""The content of a saved state of a world, as plain data.

It does not include the world's files: loading a state rebuilds the world from its files, repeats
additions and deletions made since, and then sets the values that have changed.
"""

from dataclasses import dataclass
from pathlib import Path
from typing import Any, Dict, List, Optional, Union

import numpy as np

from flatland_server import plain_data
from flatland_server.config.input_files import (
    MAX_STATE,
    read_input,
    refusal_by,
    replacing,
    require_free,
)
from flatland_server.exceptions import StateError
from flatland_server.simulation.plugin_state import PluginState

_FORMAT = 1
_FORMAT_KEY = "flatland_state"
_LATEST = 10**18
"""The greatest time of a state [ns]: ROS has stamps of up to four times as many seconds."""
_BEGINNING = f'{{"{_FORMAT_KEY}":'.encode()
"""The first bytes of each state."""


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
    content: Union[Dict[str, Any], str, None] = None
    """The data or text that it was read from, if not a file; see `ModelConfig.content`."""


@dataclass(frozen=True)
class WallsState:
    """Walls that were added since the world was made."""

    order: int
    layer: int
    segments: Any


@dataclass(frozen=True)
class FootprintState:
    """A footprint of a model that has changed footprints."""

    model: str
    body: str
    index: int
    """Among the footprints of the body."""
    radius: Optional[float]
    """Of a circle [m]; None: it is a polygon."""
    points: List[List[float]]
    """The centre of the circle, or the vertices of the polygon [m]."""
    layers: List[str]


@dataclass(frozen=True)
class WorldState:
    """The state of a world."""

    world: str
    """The path of its file, for messages."""
    seed: Any
    """A whole number of 0 or more, of any size."""
    nanoseconds: int
    """Simulated time."""
    wall_counts: Dict[str, int]
    """The number of walls of each layer when the world was made, to recognise another map."""
    models: List[ModelState]
    layout: Dict[str, List[float]]
    """See `WorldContents.layout`."""
    walls: List[WallsState]
    footprints: List[FootprintState]
    plugins: List[PluginState]
    physics: bytes
    """See `_core.World.save_state`."""
    own_walls: Any = None
    """The walls of the first layer in place of those of the world's files; see `Walls`."""
    vary: Any = None
    """The values of an environment that differ from those of the world's files, by name."""
    is_of_batch: bool = False
    """True for the state of an environment: it has the states of those plugins alone that act."""

    def dumps(self) -> bytes:
        """The state as bytes; see `plain_data`."""
        parts = {name: [vars(each) for each in getattr(self, name)] for name in _PARTS}
        return plain_data.dumps({_FORMAT_KEY: _FORMAT, **vars(self), **parts})

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
            for name, part in _PARTS.items():
                if not isinstance(content.get(name), list):
                    raise ValueError(f"{name}: expected a list")
                content[name] = [
                    plain_data.made(part, each, f"{name}[{index}]")
                    for index, each in enumerate(content[name])
                ]
            state = plain_data.made(cls, content, "state")
            if type(state.seed) is not int or state.seed < 0:
                raise ValueError(f"state.seed: expected another value, found {state.seed!r:.60}")
            poses = [*(each.pose for each in state.models), *state.layout.values()]
            if not 0 <= state.nanoseconds <= _LATEST or any(len(pose) != 3 for pose in poses):
                raise ValueError("expected a time of 0 to 1e9 s, and poses of three numbers")
            walls = [each.segments for each in state.walls]
            if state.own_walls is not None:
                walls.append(state.own_walls)
            for each in walls:
                if not (isinstance(each, np.ndarray) and each.ndim and each.dtype.kind in "fiu"):
                    raise ValueError("expected walls as arrays of numbers")
        except ValueError as error:
            raise StateError(f"the state is damaged: {error}") from None
        return state


_PARTS = {
    "models": ModelState,
    "walls": WallsState,
    "footprints": FootprintState,
    "plugins": PluginState,
}
"""The lists of a state."""


def read_state(path: Path) -> bytes:
    """A state file's content.

    Raises:
        StateError: it cannot be read, is no regular file, or is larger than 64 MiB.
    """
    return read_input(path, MAX_STATE, refusal_by(StateError))


def write_state(path: Path, state: bytes) -> None:
    """Writes a state file: completely, or not at all.

    The path may come from a client. Only a state is replaced, and no link is followed.

    Raises:
        StateError: it cannot be written, or another file is there.
    """
    try:
        require_free(path, _BEGINNING, "a saved state", StateError)
        with replacing(path) as partial:
            with partial.open("xb") as file:
                file.write(state)
            require_free(path, _BEGINNING, "a saved state", StateError)  # still
    except (OSError, ValueError) as error:  # ValueError: the name contains a zero byte
        reason = error.strerror if isinstance(error, OSError) else error
        raise StateError(f"cannot write {path}: {reason}") from None
