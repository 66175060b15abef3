"""The core's observations of robots that drive to goals, against a formula in NumPy."""

import numpy as np
import pytest

from flatland_server._core import GoalObserver

BEAMS, MAX_RANGE = 5, 8.0


def measurements(count=200):
    """Random ranges, poses, velocities and goals of robots; some beams return nothing."""
    rng = np.random.default_rng(3)
    ranges = rng.uniform(0, 12, (count, BEAMS)).astype(np.float32)
    ranges[::7, 2] = np.inf
    poses = rng.uniform(-4, 4, (count, 3))
    return ranges, poses, rng.uniform(-3, 3, (count, 3)), rng.uniform(-90, 90, (count, 2))


def expected(ranges, poses, velocities, goals, limits):
    """The observations of docs/learning.md, by complex numbers."""
    to_goal = (goals - poses[:, :2]).view(complex)[:, 0] * np.exp(-1j * poses[:, 2])
    bearing = np.angle(to_goal)
    parts = [
        np.minimum(ranges / MAX_RANGE, 1.0),
        np.minimum(np.abs(to_goal) / MAX_RANGE, 10.0)[:, None],
        np.cos(bearing)[:, None],
        np.sin(bearing)[:, None],
    ]
    parts += [np.clip(velocities[:, [k]] / limit, -2, 2) for k, limit in enumerate(limits) if limit]
    return np.concatenate(parts, axis=1)


@pytest.mark.parametrize("limits", [(0.8, 0.0, 2.0), (0.8, 0.5, 2.0), (0.0, 0.0, 0.0)])
def test_the_observation_follows_the_documented_formula(limits):
    rows = measurements()
    found = GoalObserver(BEAMS, MAX_RANGE, limits).observe(*rows)

    assert found.dtype == np.float32
    assert found.shape == (200, BEAMS + 3 + np.count_nonzero(limits))
    np.testing.assert_allclose(found, expected(*rows, limits), atol=1e-6)
    assert {found[:, BEAMS].max(), found[:, :BEAMS].max()} == {10.0, 1.0}


def test_a_row_does_not_depend_on_the_others():
    rows, observer = measurements(), GoalObserver(BEAMS, MAX_RANGE, (0.8, 0.0, 2.0))
    single = [observer.observe(*(array[k : k + 1] for array in rows)) for k in range(200)]

    assert np.concatenate(single).tobytes() == observer.observe(*rows).tobytes()
    assert observer.observe(*(array[:0] for array in rows)).shape == (0, 10)


def test_at_the_goal_it_is_ahead_and_nan_stays():
    observer = GoalObserver(2, MAX_RANGE, (1.0, 0.0, 1.0))
    ranges, pose = np.array([[np.nan, 1.0]], np.float32), np.array([[1.0, 2.0, 3.0]])
    [row] = observer.observe(ranges, pose, np.zeros((1, 3)), np.array([[1.0, 2.0]]))

    np.testing.assert_array_equal(row, np.float32([np.nan, 0.125, 0, 1, 0, 0, 0]))


def test_other_arrays_are_refused():
    rows, observer = measurements(4), GoalObserver(BEAMS, MAX_RANGE, (0.8, 0.0, 2.0))
    for number, array in enumerate(rows):
        for wrong in (array[:3], array[:, :-1].copy(), array[0].copy()):
            with pytest.raises(ValueError, match=r"expected ranges \(n, beams\)"):
                observer.observe(*rows[:number], wrong, *rows[number + 1 :])
        with pytest.raises(TypeError):
            observer.observe(*rows[:number], array.astype(complex), *rows[number + 1 :])
    for wrong in ((-1, 8.0, (1.0, 0.0, 1.0)), (5, 8.0, (1.0, 0.0))):
        with pytest.raises(ValueError, match=r"expected three limits|must be 0 or more"):
            GoalObserver(*wrong)
