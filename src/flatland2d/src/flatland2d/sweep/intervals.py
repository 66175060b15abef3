"""Confidence intervals of 95 %: Wilson's for rates, Student's t for means."""

import math
from functools import lru_cache
from statistics import NormalDist, fmean, stdev
from typing import NamedTuple, Sequence

import numpy as np

CONFIDENCE = 0.95

_Z = NormalDist().inv_cdf(0.5 + CONFIDENCE / 2)


class Interval(NamedTuple):
    """An estimate, and the ends of its confidence interval; NaN where there is none."""

    value: float
    low: float
    high: float


def rate(successes: int, count: int) -> Interval:
    """A rate, with Wilson's score interval.

    (p + z^2/2n +- z sqrt(p(1-p)/n + z^2/4n^2)) / (1 + z^2/n), with z = 1.96 (E. B. Wilson,
    "Probable inference, the law of succession, and statistical inference", 1927).

    Args:
        successes: number of successes, 0 to `count`.
        count: number of trials.
    """
    if count == 0:
        return Interval(math.nan, math.nan, math.nan)
    p, z = successes / count, _Z
    middle = p + z * z / (2 * count)
    half = z * math.sqrt(p * (1 - p) / count + z * z / (4 * count * count))
    scale = 1 + z * z / count
    low = 0.0 if successes == 0 else (middle - half) / scale
    high = 1.0 if successes == count else (middle + half) / scale
    return Interval(p, low, high)


def mean(values: Sequence[float]) -> Interval:
    """A mean, with the interval of Student's t: m +- t s / sqrt(n), s with n - 1 in it.

    Args:
        values: of n trials. One value, or one that is infinite or NaN, has no interval. Values too
            large to be added have no mean.
    """
    if not values:
        return Interval(math.nan, math.nan, math.nan)
    try:
        middle = fmean(values)
        if len(values) < 2 or not math.isfinite(middle):
            return Interval(middle, math.nan, math.nan)
        half = t_quantile(len(values) - 1) * stdev(values) / math.sqrt(len(values))
    except (OverflowError, ValueError):  # of fsum: also infinities of both signs
        return Interval(math.nan, math.nan, math.nan)
    return Interval(middle, middle - half, middle + half)


@lru_cache(maxsize=None)
def t_quantile(freedom: int) -> float:
    """The t that |T| stays below with the probability of 95 %, T having n degrees of freedom.

    The density of the angle atan(T / sqrt(n)) is proportional to the power n - 1 of its cosine: it
    is summed up to t = 12 at least, which leaves an error below 1e-8.

    Args:
        freedom: n, 1 or more.
    """
    angles = np.linspace(0.0, min(math.pi / 2, 12.0 / math.sqrt(freedom)), 100_001)
    density = np.cos(angles) ** (freedom - 1)
    sums = np.cumsum(density[1:] + density[:-1])
    return math.sqrt(freedom) * math.tan(np.interp(CONFIDENCE * sums[-1], sums, angles[1:]))
