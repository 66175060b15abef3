"""A trained policy: from observations to actions. Needs NumPy alone."""

import io
import math
import os
import struct
import zipfile
import zlib
from dataclasses import dataclass, fields
from pathlib import Path
from typing import Any, Dict, List, Sequence, Tuple, Union

import numpy as np

from flatland2d import FlatlandError, UsageError
from flatland_gym.observations import NEIGHBOR, neighbor_rows
from flatland_server import Float32Array, FloatArray, PoseLike
from flatland_server._core import GoalObserver
from flatland_server.arguments import path_of
from flatland_server.arrays import npy_array
from flatland_server.config import MIB, read_input, refusal_by

_FORMAT = "flatland policy 1"

_LARGEST = 64 * MIB  # bytes

_NOT_OF_NUMPY = (
    *(zipfile.BadZipFile, zlib.error, EOFError, KeyError, TypeError, RuntimeError),
    *(NotImplementedError, OverflowError, struct.error),
)
"""Errors of files that are no archive, or of an odd one."""

_POLICIES = Path(__file__).resolve().parent / "policies"
_SHIPPED = ("discs",)


@dataclass(frozen=True)
class Policy:
    """A network of layers with tanh between them, and the robot that it was trained for.

    Attributes:
        weights: of each layer, shape (inputs, outputs).
        biases: of each layer, shape (outputs,).
        beams: number of the lidar's beams.
        max_range: the lidar's max range [m].
        velocity_limits: see `Robot.velocity_limits`.
        action_limits: see `Robot.action_limits`.
        period: between two actions [s].
        neighbors: how many of the nearest other models it is told about.
        neighbor_range: the largest gap of these [m].
        neighbors_behind_walls: whether it is told about models that a wall hides.
    """

    weights: Tuple[Float32Array, ...]
    biases: Tuple[Float32Array, ...]
    beams: int
    max_range: float
    velocity_limits: Tuple[float, ...]
    action_limits: Tuple[float, ...]
    period: float
    neighbors: int = 0
    neighbor_range: float = math.inf
    neighbors_behind_walls: bool = False

    def act(self, observations: Float32Array) -> Float32Array:
        """The actions for flat observations: shape (n, size of an action), within the limits.

        Args:
            observations: shape (n, size of an observation).

        Raises:
            UsageError: the observations have another size.
        """
        size = self.weights[0].shape[0]
        if observations.ndim != 2 or observations.shape[1] != size:
            raise UsageError(
                f"expected observations of shape (n, {size}), found {observations.shape}"
            )
        outputs = layer_values(self.weights, self.biases, observations)[-1]
        limits = np.array(self.action_limits, np.float32)
        actions: Float32Array = np.clip(outputs, -1.0, 1.0) * limits
        return actions

    def drive(
        self, ranges: Any, pose: PoseLike, velocity: Any, goal: Any, neighbors: Any = None
    ) -> List[float]:
        """The action for the measurements of a robot that runs outside of an environment.

        Args:
            ranges: of the lidar [m], shape (beams,); +inf, or NaN as of some lidars, for no return.
            pose: x, y [m] and yaw [rad].
            velocity: in the robot's frame: forwards, to the left, turning [m/s, m/s, rad/s].
            goal: x, y [m], in the frame of the pose.
            neighbors: other models, for a policy with neighbours: shape (m, 5), x, y [m], vx, vy
                [m/s] in the frame of the pose, and the radius of the model and the robot together;
                those in sight, unless it has `neighbors_behind_walls`.

        Raises:
            UsageError: neighbours are missing, a shape is another one, or a number is not finite.
        """
        rows = _row("pose", pose, 3), _row("velocity", velocity, 3), _row("goal", goal, 2)
        scan = np.array([ranges], np.float32)
        scan[np.isnan(scan)] = np.inf
        if scan.shape[1:] != (self.beams,):
            raise UsageError(f"expected {self.beams} ranges, found shape {scan.shape[1:]}")
        observer = GoalObserver(self.beams, self.max_range, self.velocity_limits)
        observation = observer.observe(scan, *rows)
        if self.neighbors:
            near = _neighbors(neighbors)
            parts = neighbor_rows(*rows[:2], near[None], self.neighbors, self.neighbor_range)
            observation = np.concatenate([observation, parts], axis=1)
        action: List[float] = self.act(observation)[0].tolist()
        return action

    def save(self, path: Union[str, "os.PathLike[str]"]) -> None:
        """Writes the policy into a file of NumPy's.

        Args:
            path: of the file, which ends in .npz.
        """
        content: Dict[str, Any] = {"format": _FORMAT, "layers": len(self.weights)}
        content.update((each.name, getattr(self, each.name)) for each in fields(self)[2:])
        for number, (weight, bias) in enumerate(zip(self.weights, self.biases)):
            content[f"weight_{number}"], content[f"bias_{number}"] = weight, bias
        with open(path, "wb") as file:
            np.savez_compressed(file, **content)

    @classmethod
    def load(cls, path: Union[str, "os.PathLike[str]"]) -> "Policy":
        """Reads a file written by `save`.

        Args:
            path: of the file; or "discs", the policy that comes with this package.

        Raises:
            FlatlandError: the file cannot be read, or is none of a policy.
        """
        if str(path) in _SHIPPED:
            path = _POLICIES / f"{path}.npz"
        found = path_of(path, "the path of a policy")
        content = _arrays(read_input(found, _LARGEST, refusal_by(FlatlandError)), found)
        try:
            if str(content["format"]) != _FORMAT:
                raise ValueError(f'the format is "{content["format"]}"')
            numbers = range(int(content["layers"]))
            policy = cls(
                tuple(content[f"weight_{number}"] for number in numbers),
                tuple(content[f"bias_{number}"] for number in numbers),
                int(content["beams"]),
                float(content["max_range"]),
                tuple(content["velocity_limits"].tolist()),
                tuple(content["action_limits"].tolist()),
                float(content["period"]),
                # These are not in files of former versions.
                int(content.get("neighbors", 0)),
                float(content.get("neighbor_range", math.inf)),
                bool(content.get("neighbors_behind_walls", False)),
            )
            policy._require_sound()
            return policy
        except KeyError as error:
            raise FlatlandError(f"expected a file of a policy, but {path} lacks {error}") from None
        except (TypeError, ValueError, OverflowError) as error:
            raise FlatlandError(f"expected a file of a policy, but {path}: {error}") from None

    def _require_sound(self) -> None:
        """Raises a ValueError unless the layers fit to the robot and all values are finite."""
        limits = (*self.velocity_limits, *self.action_limits)
        if not (
            len(self.velocity_limits) == 3 and all(0.0 <= limit < math.inf for limit in limits)
        ):
            raise ValueError(f"its limits are {limits}")
        if not all(0.0 < value < math.inf for value in (self.period, self.max_range)):
            raise ValueError(f"its period is {self.period} s, its range {self.max_range} m")
        parts = sum(limit > 0.0 for limit in self.velocity_limits)
        if self.neighbors < 0 or not self.neighbor_range > 0.0:
            raise ValueError(f"it has {self.neighbors} neighbours up to {self.neighbor_range} m")
        size = self.beams + 3 + parts + NEIGHBOR * self.neighbors
        for weight, bias in zip(self.weights, self.biases):
            if weight.ndim != 2 or weight.shape[0] != size or bias.shape != weight.shape[1:]:
                raise ValueError(f"a layer of {size} inputs has shape {weight.shape}, {bias.shape}")
            if not (np.isfinite(weight).all() and np.isfinite(bias).all()):
                raise ValueError("its weights are not finite")
            size = bias.size
        if size != len(self.action_limits):
            raise ValueError(f"{size} outputs for {len(self.action_limits)} parts of an action")


def layer_values(
    weights: Sequence[Float32Array], biases: Sequence[Float32Array], inputs: Float32Array
) -> List[Float32Array]:
    """The inputs and the outputs of all layers of a network: shape (n, size) each."""
    values = [inputs]
    for number, (weight, bias) in enumerate(zip(weights, biases)):
        value = values[-1] @ weight + bias
        values.append(np.tanh(value) if number < len(weights) - 1 else value)
    return values


def _arrays(content: bytes, path: Path) -> Dict[str, Any]:
    """The arrays of a file of NumPy's.

    Raises:
        FlatlandError: it is none, or an array takes more memory than a policy.
    """
    try:
        with zipfile.ZipFile(io.BytesIO(content)) as archive:
            if sum(each.file_size for each in archive.infolist()) > _LARGEST:
                raise ValueError("its arrays are too large")
            parts = {each.filename: archive.read(each) for each in archive.infolist()}
        return {name[: -len(".npy")]: npy_array(data) for name, data in parts.items()}
    except (*_NOT_OF_NUMPY, ValueError) as error:
        raise FlatlandError(f"expected a file of a policy, but {path}: {error}") from None


def _row(name: str, value: Any, size: int) -> FloatArray:
    """Some finite numbers as an array of one row.

    Raises:
        UsageError: they are something else.
    """
    try:
        row: FloatArray = np.array([value], dtype=float)
    except (TypeError, ValueError):
        row = np.empty(0)
    if row.shape != (1, size) or not np.isfinite(row).all():
        raise UsageError(f"expected the {name} as {size} finite numbers, found {value!r:.80}")
    return row


def _neighbors(value: Any) -> FloatArray:
    """Other models as an array of a row for each.

    Raises:
        UsageError: they are something else.
    """
    try:
        found = np.array(value, dtype=float)
    except (TypeError, ValueError):
        found = np.empty(0)
    found = found.reshape(0, 5) if value is not None and not found.size else found
    if found.ndim != 2 or found.shape[1] != 5 or not np.isfinite(found).all():
        raise UsageError(
            "expected the neighbors, for which the policy was trained, as rows of x, y, vx, vy and "
            f"radius, found {value!r:.80}"
        )
    return found
