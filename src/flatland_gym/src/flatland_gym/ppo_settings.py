"""The settings of proximal policy optimisation."""

import math
from dataclasses import dataclass, fields
from typing import Any, Dict, Mapping, Tuple

from flatland2d import UsageError


@dataclass(frozen=True)
class PpoSettings:
    """The parameters of a training.

    Attributes:
        rollout: steps of each environment between two updates.
        minibatch: rows of a gradient step.
        epochs: how often an update uses each row.
        learning_rate: at the beginning; it falls to a tenth of that.
        discount: of rewards, per step.
        trace: the lambda of generalised advantage estimation.
        clip: how far the ratio of probabilities may leave 1.
        entropy: weight of the policy's entropy.
        hidden: sizes of the hidden layers.
        log_std: of the actions at the beginning, in units of their limits.
        mirror: whether left and right are exchanged in half of the rows, as the mirror image of a
            motion is one as well; for robots with a lidar that looks to both sides alike.
    """

    rollout: int = 64
    minibatch: int = 1024
    epochs: int = 6
    learning_rate: float = 1e-3
    discount: float = 0.99
    trace: float = 0.95
    clip: float = 0.2
    entropy: float = 1e-3
    hidden: Tuple[int, ...] = (64, 64)
    log_std: float = -0.5
    mirror: bool = True

    @classmethod
    def of(cls, values: Mapping[str, Any]) -> "PpoSettings":
        """Settings out of values by their names, as from a command.

        Raises:
            UsageError: one is unknown or wrong.
        """
        known: Dict[str, Any] = {each.name: each.default for each in fields(cls)}
        found: Dict[str, Any] = {}
        for name, value in values.items():
            if name not in known:
                raise UsageError(
                    f'the learner has no setting "{name}"; there are: {", ".join(known)}'
                )
            try:
                found[name] = _like(known[name], value)
            except (TypeError, ValueError, OverflowError):
                raise UsageError(
                    f"expected the learner's {name} as something like {known[name]}, found {value}"
                ) from None
        return cls(**found)


def _like(default: Any, value: Any) -> Any:
    """A value of the type of another one: a boolean, or finite, and whole numbers above 0.

    Raises:
        ValueError: it is none; also TypeError, OverflowError.
    """
    if isinstance(default, tuple):
        return tuple(_like(default[0], each) for each in value)
    if type(default) is bool and not isinstance(value, bool):
        raise ValueError
    found = type(default)(value)
    if not math.isfinite(found) or (type(default) is int and found < 1):
        raise ValueError
    return found
