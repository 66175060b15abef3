"""A trained policy: what a robot does with what it sees. Needs NumPy alone."""

import os
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Dict, List, Tuple, Union

import numpy as np

from flatland_gym.observations import observe
from flatland_server import FlatlandError, Float32Array, FloatArray, UsageError

_FORMAT = "flatland policy 1"

_POLICIES = Path(__file__).resolve().parent / "policies"
_SHIPPED = ("discs",)


@dataclass(frozen=True)
class Policy:
    """A network of layers with tanh between them, and the robot that it was trained for.

    Attributes:
        weights: of each layer, shape (inputs, outputs).
        biases: of each layer, shape (outputs,).
        beams: of the lidar.
        max_range: of the lidar [m].
        velocity_limits: see `Robot.velocity_limits`.
        action_limits: see `Robot.action_limits`.
        period: between two actions [s].
    """

    weights: Tuple[Float32Array, ...]
    biases: Tuple[Float32Array, ...]
    beams: int
    max_range: float
    velocity_limits: Tuple[float, ...]
    action_limits: Tuple[float, ...]
    period: float

    def act(self, observations: Float32Array) -> Float32Array:
        """The actions for flat observations: shape (n, size of an action), within the limits.

        Raises:
            UsageError: the observations have another size.
        """
        size = self.weights[0].shape[0]
        if observations.ndim != 2 or observations.shape[1] != size:
            raise UsageError(
                f"expected observations of shape (n, {size}), found {observations.shape}"
            )
        values = observations
        for number, (weight, bias) in enumerate(zip(self.weights, self.biases)):
            values = values @ weight + bias
            if number < len(self.weights) - 1:
                values = np.tanh(values)
        limits = np.array(self.action_limits, np.float32)
        actions: Float32Array = np.clip(values, -1.0, 1.0) * limits
        return actions

    def drive(self, ranges: Any, pose: Any, velocity: Any, goal: Any) -> List[float]:
        """The action for what a robot measures; for one that runs outside of an environment.

        Args:
            ranges: of the lidar [m], shape (beams,); +inf for no return.
            pose: x, y [m] and yaw [rad].
            velocity: in the robot's frame: forwards, to the left, turning [m/s, m/s, rad/s].
            goal: x, y [m], in the frame of the pose.
        """
        rows: List[FloatArray] = [np.array([each], dtype=float) for each in (pose, velocity, goal)]
        scan = np.array([ranges], np.float32)
        limits = np.array(self.velocity_limits)
        observation = observe(scan, rows[0], rows[1], rows[2], self.max_range, limits)
        action: List[float] = self.act(observation)[0].tolist()
        return action

    def save(self, path: Union[str, "os.PathLike[str]"]) -> None:
        """Writes it into a file of NumPy's (.npz)."""
        layers: Dict[str, Any] = {}
        for number, (weight, bias) in enumerate(zip(self.weights, self.biases)):
            layers[f"weight_{number}"], layers[f"bias_{number}"] = weight, bias
        with open(path, "wb") as file:
            np.savez_compressed(
                file,
                format=np.array(_FORMAT),
                layers=np.array(len(self.weights)),
                beams=np.array(self.beams),
                max_range=np.array(self.max_range),
                velocity_limits=np.array(self.velocity_limits),
                action_limits=np.array(self.action_limits),
                period=np.array(self.period),
                **layers,
            )

    @classmethod
    def load(cls, path: Union[str, "os.PathLike[str]"]) -> "Policy":
        """Reads what `save` has written.

        Args:
            path: of the file; or "discs", the policy that comes with this package.

        Raises:
            FlatlandError: the file cannot be read, or is none of a policy.
        """
        if str(path) in _SHIPPED:
            path = _POLICIES / f"{path}.npz"
        try:
            with np.load(path, allow_pickle=False) as file:
                content = {name: file[name] for name in file.files}
            if str(content["format"]) != _FORMAT:
                raise ValueError(f'the format is "{content["format"]}"')
            numbers = range(int(content["layers"]))
            return cls(
                tuple(content[f"weight_{number}"] for number in numbers),
                tuple(content[f"bias_{number}"] for number in numbers),
                int(content["beams"]),
                float(content["max_range"]),
                tuple(content["velocity_limits"].tolist()),
                tuple(content["action_limits"].tolist()),
                float(content["period"]),
            )
        except OSError as error:
            raise FlatlandError(f"{path} cannot be read: {error.strerror or error}") from None
        except (KeyError, ValueError, EOFError) as error:
            raise FlatlandError(f"expected a file of a policy, but {path}: {error}") from None
