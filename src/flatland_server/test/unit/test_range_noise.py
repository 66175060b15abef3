"""The noise of lidars: Gaussian, and a function of key, time and beam."""

from statistics import NormalDist

import numpy as np
import pytest

from flatland_server import RangeNoise

COUNT = 200_000


def noise_of(key, nanoseconds=0, count=COUNT):
    """The noise of ranges in units of the standard deviation."""
    ranges = np.full(count, 50.0, np.float32)
    return (RangeNoise(key, 2.0, 100.0)(ranges, nanoseconds).astype(np.float64) - 50.0) / 2.0


def test_range_noise_is_normally_distributed():
    noise = np.sort(noise_of(7))

    assert abs(noise.mean()) < 4 / COUNT**0.5
    # Kolmogorov and Smirnov: 1.95 / sqrt(n) is exceeded once in a thousand.
    places = [NormalDist().cdf(value) for value in noise[::20].tolist()]
    expected = np.arange(0, COUNT, 20) / COUNT
    assert np.abs(np.array(places) - expected).max() < 1.95 / COUNT**0.5
    assert 4.0 < noise[-1] < 6.5
    assert -6.5 < noise[0] < -4.0
    assert (noise > 3.0).sum() == pytest.approx(COUNT * NormalDist().cdf(-3.0), rel=0.2)


def test_beams_times_and_keys_have_noise_of_their_own():
    rows = [noise_of(7), noise_of(8), noise_of(7, 1), noise_of(7, 50_000_000), noise_of(2**63)]

    correlations = np.corrcoef(rows) - np.eye(5)
    assert np.abs(correlations).max() < 4.5 / COUNT**0.5
    following = [abs(np.corrcoef(rows[0][:-lag], rows[0][lag:])[0, 1]) for lag in (1, 2, 3, 64)]
    assert max(following) < 4.5 / COUNT**0.5
    # The same beam at 20 times a second.
    one = np.array([noise_of(7, step * 50_000_000, 1)[0] for step in range(5000)])
    assert abs(np.corrcoef(one[:-1], one[1:])[0, 1]) < 4.5 / 5000**0.5


def test_equal_keys_and_times_have_equal_noise():
    assert np.array_equal(noise_of(7, 3), noise_of(7, 3))


def test_ranges_stay_possible():
    ranges = np.array([0.0, 0.001, 9.999, 10.0, np.inf] * 50, np.float32)

    noisy = RangeNoise(1, 0.5, 10.0)(ranges, 5)

    assert noisy.dtype == np.float32
    assert np.array_equal(np.isinf(noisy), np.isinf(ranges))
    finite = noisy[np.isfinite(noisy)]
    assert (finite.min(), finite.max()) == (0.0, 10.0)
    assert (ranges[:2] == np.float32([0.0, 0.001])).all()  # it is not written to


def test_rows_have_the_noise_of_their_keys_and_times():
    ranges = np.full((3, 5), 50.0, np.float32)
    keys, times = np.array([4, 5, 6], np.uint64), np.array([10, 20, 30])
    noise = RangeNoise(0, 2.0, 100.0)

    noise.add_to_rows(ranges, keys, times, np.array([True, False, True]))

    one = np.full(5, 50.0, np.float32)
    assert np.array_equal(ranges[0], RangeNoise(4, 2.0, 100.0)(one, 10))
    assert np.array_equal(ranges[1], one)
    assert np.array_equal(ranges[2], RangeNoise(6, 2.0, 100.0)(one, 30))
    with pytest.raises(ValueError, match="expected ranges"):
        noise.add_to_rows(ranges, keys[:2], times, None)


@pytest.mark.parametrize("values", [(-1.0, 1.0), (np.inf, 1.0), (np.nan, 1.0), (1.0, -1.0)])
def test_impossible_noise_is_refused(values):
    with pytest.raises(ValueError, match="0 or more"):
        RangeNoise(1, *values)
