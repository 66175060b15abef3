"""Rewards and terminations of a step, by the functions of the settings if there are any."""

from typing import Any, Tuple

import numpy as np

from flatland2d import UsageError
from flatland_gym.rewards import Transition, navigation_reward, navigation_termination
from flatland_gym.settings import NavigationSettings
from flatland_server import BoolArray, FloatArray


def evaluate_step(
    transition: Transition, settings: NavigationSettings
) -> Tuple[FloatArray, BoolArray]:
    """Rewards and terminations of n environments, by the settings' functions if there are any.

    Raises:
        UsageError: such a function has returned another shape, or no finite numbers.
    """
    count, step = len(transition.distance), transition
    if settings.reward is not None or settings.terminated is not None:
        arrays = {name: frozen(getattr(transition, name)) for name in Transition._fields[:-2]}
        step = transition._replace(**arrays)
    if settings.reward is None:
        rewards = navigation_reward(step, settings.rewards)
    else:
        rewards = _result("reward", settings.reward(step), np.float64, count)
    if settings.terminated is None:
        terminated = navigation_termination(step, settings.collision_ends)
    else:
        terminated = _result("terminated", settings.terminated(step), np.bool_, count)
    return rewards, terminated


def frozen(array: Any) -> Any:
    """A read-only view."""
    view = array.view()
    view.flags.writeable = False
    return view


def _result(name: str, value: Any, kind: Any, count: int) -> Any:
    """The checked result of a user's function, as an array of n values."""
    result = np.asarray(value)
    if result.shape != (count,):
        raise UsageError(f"expected {name} to return shape ({count},), found {result.shape}")
    if result.dtype.kind not in "biuf" or not np.isfinite(result).all():
        raise UsageError(f"expected {name} to return finite numbers, found {result!r:.80}")
    return result.astype(kind)
