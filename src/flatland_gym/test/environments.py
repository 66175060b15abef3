"""Helpers for tests of environments."""

import gymnasium as gym
import numpy as np

import flatland_gym  # noqa: F401  registers the environments

ID = "flatland/Navigation-v0"


def make(**arguments):
    """A single environment without Gymnasium's wrappers."""
    return gym.make(ID, **arguments).unwrapped


def make_vector(num_envs, **arguments):
    """A vector environment."""
    return gym.make_vec(ID, num_envs=num_envs, **arguments)


def assert_same(a, b, path=""):
    """Fails unless two results are equal to the bit, with their types and shapes."""
    if isinstance(a, dict):
        assert isinstance(b, dict), path
        assert set(a) == set(b), path
        for key in a:
            assert_same(a[key], b[key], f"{path}.{key}")
    elif isinstance(a, (tuple, list)):
        assert len(a) == len(b), path
        for index, (x, y) in enumerate(zip(a, b)):
            assert_same(x, y, f"{path}[{index}]")
    elif isinstance(a, np.ndarray) and a.dtype == object:
        assert a.shape == b.shape, path
        assert_same(list(a), list(b), path)
    elif isinstance(a, np.ndarray):
        assert (a.dtype, a.shape) == (b.dtype, b.shape), path
        assert a.tobytes() == b.tobytes(), path
    else:
        assert a == b, path
