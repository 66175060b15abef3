"""Observations that a user composes: parts of ours by their names, map crops, and functions.

gym.make(ID, observation=["ranges", "goal", MapCrop(), speed_of_people], privileged="models")
"""

from dataclasses import dataclass
from functools import lru_cache
from typing import Any, Callable, Dict, List, NamedTuple, Sequence, Tuple, Union

import numpy as np
from gymnasium import spaces

from flatland2d import UsageError
from flatland_gym.observations import NEIGHBOR, STANDARD, as_dict, bounds, neighbor_rows
from flatland_gym.rewards import OtherModels
from flatland_server import BoolArray, Float32Array, FloatArray, IntArray, Segments, cos_sin
from flatland_server._core import FloorSquares, lower_to_walls
from flatland_server.exceptions import suggestion

_MOST_SQUARES = 4_000_000
_MOST_KEPT = 4096
"""Maps of squares that are kept."""


class Situation(NamedTuple):
    """The present state of n robots, for functions that observe it.

    Arrays are read-only, and valid during the call.
    """

    poses: FloatArray
    """x, y [m] and yaw [rad] in the world, shape (n, 3)."""
    velocities: FloatArray
    """Forwards, to the left and turning [m/s, m/s, rad/s], shape (n, 3)."""
    goals: FloatArray
    """x, y [m] in the world, shape (n, 2)."""
    ranges: Float32Array
    """Ranges of the lidar [m], +inf for no return: float32, shape (n, beams)."""
    models: OtherModels
    """The other models of the world."""


Function = Callable[[Situation], Any]
"""Observes n robots: an array of numbers of shape (n, ...)."""


@dataclass(frozen=True)
class ObservationPart:
    """A part of observations that a function computes.

    Attributes:
        function: takes a `Situation`, and returns an array of shape (n, *shape).
        shape: of the part of one robot; () for a number.
        low: the least value.
        high: the largest value.
        name: its key in observations that are dicts; by default that of the function.
    """

    function: Function
    shape: Tuple[int, ...] = ()
    low: float = -np.inf
    high: float = np.inf
    name: str = ""


@dataclass(frozen=True)
class MapCrop:
    """The part `map`: the map around the robot, 1 in squares with a wall and 0 in others.

    A square has one if its middle is nearer to a wall than half its diagonal.

    Squares are in the robot's frame: `map[i, j]` is farther ahead the larger i is, and farther to
    the left the larger j is; the robot is in the middle. The map has the walls of the world's
    files, or of the episode's map: no models, and no walls that plugins add.

    Attributes:
        cells: along each side.
        resolution: side of a square [m].
    """

    cells: int = 32
    resolution: float = 0.2

    def __post_init__(self) -> None:
        if not (isinstance(self.cells, (int, np.integer)) and 1 <= self.cells <= 1000):
            raise UsageError(f"expected 1 to 1000 cells of a MapCrop, found {self.cells!r}")
        if not (isinstance(self.resolution, (int, float)) and 1e-3 <= self.resolution < 1e6):
            raise UsageError(f"expected a resolution above 1 mm, found {self.resolution!r}")


Part = Union[str, MapCrop, ObservationPart, Function]

OURS = (*STANDARD, "map", "pose", "models")
"""The names of our parts."""


def _squares(walls: Segments, resolution: float) -> FloorSquares:
    """The squares of a map with walls."""
    ends = walls.reshape(-1, 2) if len(walls) else np.zeros((1, 2))
    corner = ends.min(axis=0) - 2.0 * resolution
    columns, rows = np.ceil((ends.max(axis=0) - corner) / resolution).astype(int) + 2
    if rows * columns > _MOST_SQUARES:
        expected = f"expected a map of up to {_MOST_SQUARES} squares of {resolution:g} m"
        raise UsageError(f"{expected}, found {columns} x {rows}: a MapCrop may have larger ones")
    squared, reach = np.full((rows, columns), np.inf), float(np.sqrt(0.5) * resolution)
    place = float(corner[0]), float(corner[1])
    lower_to_walls(squared, np.ascontiguousarray(walls, np.float64), reach, place, resolution)
    return FloorSquares(squared <= reach**2, place, resolution)


class Known(NamedTuple):
    """The data that parts are computed from, besides a `Situation`.

    Attributes:
        flat: the observations without parts of a user's own, (n, size).
        radii: of other models and the robot together [m], (n, m).
        places: the indices of the robots' worlds, or the numbers of their maps, (n,).
    """

    situation: Situation
    flat: Float32Array
    radii: FloatArray
    places: IntArray


class _Column(NamedTuple):
    """A part as it is computed.

    Attributes:
        compute: takes what is `Known`; returns an array of shape (n, size).
    """

    name: str
    shape: Tuple[int, ...]
    low: Any
    high: Any
    compute: Callable[[Known], Any]


class Parts:
    """Observations of a list of parts.

    Args:
        parts: of `observation` or `privileged`, as a user has given them.
        beams: number of the lidar's beams.
        velocities: number of velocity components.
        neighbors: number of neighbours in an observation.
        walls_at: returns the walls of a place, see `Known`.
        models: the names of all other models, m.

    Raises:
        UsageError: there is no such part, or one cannot be computed.
    """

    def __init__(
        self,
        parts: Sequence[Part],
        beams: int,
        velocities: int,
        neighbors: int,
        walls_at: Callable[[int], Segments],
        models: Tuple[str, ...],
    ) -> None:
        self._sizes = beams, neighbors
        self._models = models
        self._ends = bounds(beams, velocities, neighbors)
        self._walls_at = walls_at
        self._columns = [self._column(part) for part in parts]
        names = [each.name for each in self._columns]
        for name in names:
            if names.count(name) > 1:
                raise UsageError(f'expected parts of different names, found "{name}" twice')
        sizes = [int(np.prod(each.shape)) for each in self._columns]
        self._stops = np.cumsum(sizes).tolist()
        low, high = (
            np.concatenate(
                [np.broadcast_to(getattr(each, end), each.shape).ravel() for each in self._columns]
            ).astype(np.float32)
            for end in ("low", "high")
        )
        self.flat_space = spaces.Box(low, high, dtype=np.float32)

    @property
    def dict_space(self) -> spaces.Dict:
        """The space of observations as dicts: a new one."""
        low, high = map(self.as_dict, (self.flat_space.low, self.flat_space.high))
        return spaces.Dict({k: spaces.Box(low[k], high[k], dtype=np.float32) for k in low})

    def flat(self, known: Known) -> Float32Array:
        """Observations of n robots: a new array of shape (n, size)."""
        count = len(known.flat)
        rows = np.empty((count, self._stops[-1]), np.float32)
        start = 0
        for each, stop in zip(self._columns, self._stops):
            rows[:, start:stop] = np.reshape(each.compute(known), (count, -1))
            start = stop
        return rows

    def as_dict(self, rows: Float32Array) -> Dict[str, Any]:
        """The parts of flat observations, as copies; along the last axis."""
        pieces = np.split(rows, self._stops[:-1], axis=-1)
        return {
            each.name: piece.reshape((*rows.shape[:-1], *each.shape)).copy()
            for each, piece in zip(self._columns, pieces)
        }

    def _column(self, part: Part) -> _Column:
        if isinstance(part, MapCrop):
            return self._map(part)
        if isinstance(part, ObservationPart):
            return self._own(part)
        if callable(part):
            name = getattr(part, "__name__", "observation")
            return self._own(ObservationPart(part, self._shape_of(part, name)))
        if part not in OURS:
            known = ", ".join(OURS)
            found = f"{part!r}{suggestion(part, OURS)}" if isinstance(part, str) else repr(part)
            raise UsageError(
                "expected parts of observations: functions, ObservationPart, MapCrop, or of "
                f"{known}; found {found}"
            )
        if part == "map":
            return self._map(MapCrop())
        if part == "pose":
            return _Column(part, (4,), [-np.inf, -np.inf, -1, -1], [np.inf, np.inf, 1, 1], _pose)
        if part == "models":
            count = max(1, len(self._models))
            low, high = (as_dict(end, 0, count)["neighbors"] for end in bounds(0, 0, count))
            return _Column(part, (count, NEIGHBOR), low, high, _models)
        low, high = (as_dict(end, *self._sizes) for end in self._ends)
        if part not in low:
            raise UsageError('expected neighbors above 0 for the part "neighbors"')
        return _Column(
            part,
            low[part].shape,
            low[part],
            high[part],
            lambda known: as_dict(known.flat, *self._sizes)[part],
        )

    def _map(self, crop: MapCrop) -> _Column:
        walls_at, resolution = self._walls_at, float(crop.resolution)

        @lru_cache(_MOST_KEPT)
        def squares(place: int) -> FloorSquares:
            return _squares(walls_at(place), resolution)

        def compute(known: Known) -> BoolArray:
            found = np.empty((len(known.flat), crop.cells**2), bool)
            for place in np.unique(known.places).tolist():
                rows = known.places == place
                found[rows] = squares(place).crop(known.situation.poses[rows], int(crop.cells))
            return found

        return _Column("map", (crop.cells, crop.cells), 0.0, 1.0, compute)

    def _own(self, part: ObservationPart) -> _Column:
        name = part.name or getattr(part.function, "__name__", "observation")

        def compute(known: Known) -> Any:
            expected = (len(known.flat), *part.shape)
            return _numbers(part.function(known.situation), expected, name)

        return _Column(name, part.shape, part.low, part.high, compute)

    def _shape_of(self, function: Function, name: str) -> Tuple[int, ...]:
        """The shape of what a function returns for one robot."""
        nothing = np.zeros((1, len(self._models), 3))
        models = OtherModels(self._models, lambda: (nothing, nothing))
        ranges = np.ones((1, self._sizes[0]), np.float32)
        poses, velocities, goals = (np.zeros((1, size)) for size in (3, 3, 2))
        found = np.asarray(function(Situation(poses, velocities, goals, ranges, models)))
        _numbers(found, (1, *found.shape[1:]), name)
        return found.shape[1:]


def parts_of(value: Any) -> List[Part]:
    """The parts of an argument: one, or a sequence of them."""
    is_many = isinstance(value, (list, tuple))
    return list(value) if is_many else [value]


def _numbers(found: Any, shape: Tuple[int, ...], name: str) -> Any:
    array = np.asarray(found)
    if array.shape != shape or array.dtype.kind not in "biuf":
        raise UsageError(
            f'expected numbers of shape {shape} from the observation "{name}", found '
            f"{array.dtype} of shape {array.shape}"
        )
    return array


def _pose(known: Known) -> FloatArray:
    poses = known.situation.poses
    return np.column_stack([poses[:, :2], *cos_sin(poses[:, 2])])


def _models(known: Known) -> Float32Array:
    now = known.situation
    motions = now.models.poses[..., :2], now.models.velocities[..., :2]
    others = np.concatenate([*motions, known.radii[..., None]], axis=-1)
    count = max(1, others.shape[1])
    return neighbor_rows(now.poses, now.velocities, others, count, np.inf)
