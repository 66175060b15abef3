"""Arguments of the vector environment: seeds, actions, options; wrong ones change nothing."""

import numpy as np
import pytest
from environments import assert_same, make_vector

from flatland2d import UsageError

pytestmark = pytest.mark.slow


def test_seeds_may_be_one_for_all_or_one_for_each():
    env = make_vector(3, world="empty_room")
    one = env.reset(seed=5)
    each = env.reset(seed=[5, 6, 7])
    assert_same(one, each)
    assert env.unwrapped.np_random_seed == (5, 6, 7)
    later = env.reset()
    assert not np.array_equal(one[0], later[0])
    env.reset(seed=5)
    assert_same(env.reset(), later)


WRONG_ACTIONS = [
    (np.zeros((2, 2)), r"expected actions of shape \(3, 2\), found \(2, 2\)"),
    (np.zeros(6), r"found \(6,\)"),
    (np.array([[0, 0], [0, np.nan], [0, 0]]), r"found nan at \(1, 1\)"),
    (np.full((3, 2), np.inf), r"expected finite actions, found inf at \(0, 0\)"),
    ([["a", "b"]] * 3, "expected actions of numbers"),
    (np.zeros((3, 2), bool), "expected actions of numbers, found bool"),
    (np.zeros((3, 2), complex), "expected actions of numbers, found complex128"),
    (None, "expected actions of numbers, found object"),
    ([[0, 1], [2], [3, 4]], "expected actions of numbers, found"),
]
WRONG_OPTIONS = [
    ({"goal": [5.0, 0.0]}, r"expected a goal that is free .*, found \[5, 0\], at most 0 m"),
    ({"goal": [50, 50]}, "outside of the world"),
    ({"start": [4.9, 0, 0]}, "expected a start that is free"),
    ({"goal": [0]}, r"expected the option goal as \[x, y\], found \[0\]"),
    ({"goal": [0, float("nan")]}, "expected the option goal"),
    ({"start": "here"}, r"expected the option start as \[x, y\] or \[x, y, yaw\]"),
    ({"world": "office"}, "expected the option world to be one of: empty_room; found 'office'"),
    ([1], r"expected options as a dict, found \[1\]"),
    ({"gaol": [0, 0]}, "unknown option 'gaol'; there are: start, goal, world"),
    ({"reset_mask": np.ones(2, bool)}, "expected reset_mask as an array of 3 booleans"),
    ({"reset_mask": np.zeros(3, bool)}, "one at least true"),
    ({"reset_mask": [True, False, True]}, "expected reset_mask as an array"),
]


@pytest.mark.parametrize(
    ("method", "arguments", "message"),
    [("step", {"actions": actions}, message) for actions, message in WRONG_ACTIONS]
    + [("reset", {"options": each, "seed": 7}, message) for each, message in WRONG_OPTIONS],
)
def test_wrong_calls_change_nothing(method, arguments, message):
    a, b = (make_vector(3, world="empty_room", beams=8) for _ in range(2))
    right = np.tile(np.float32([0.5, 0.5]), (3, 1))
    for env in (a, b):
        env.reset(seed=1)
        env.step(right)

    with pytest.raises(UsageError, match=message):
        getattr(a.unwrapped, method)(**arguments)

    assert_same(a.step(right), b.step(right))
    assert a.unwrapped.np_random_seed == b.unwrapped.np_random_seed


def test_a_step_after_an_end_is_refused_without_autoreset():
    env = make_vector(2, world="empty_room", autoreset_mode="Disabled", time_limit=0.1)
    env.reset(seed=1)
    for _ in range(2):
        env.step(np.zeros((2, 2), np.float32))

    with pytest.raises(UsageError, match=r"episodes have ended: \[0, 1\]"):
        env.step(np.zeros((2, 2), np.float32))


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"num_envs": 0}, "expected num_envs to be a whole number above 0, found 0"),
        ({"num_envs": 2, "threads": 1.5}, "expected threads to be a whole number"),
        ({"num_envs": 2, "max_episode_steps": 0}, "expected max_episode_steps to be"),
        ({"num_envs": 2, "autoreset_mode": "Never"}, "expected autoreset_mode to be one of"),
        ({"num_envs": 2, "render_mode": "human"}, "for a single environment"),
        ({"num_envs": 2, "render_envs": 0}, "expected render_envs to be a whole number above 0"),
        (
            {"num_envs": 2, "wrold": "office"},
            r"""argument 'wrold' \(did you mean "world"\?\); there are: world, robot""",
        ),
    ],
)
def test_wrong_arguments_are_named(arguments, message):
    with pytest.raises(UsageError, match=message):
        make_vector(**arguments)
