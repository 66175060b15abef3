"""Confidence intervals of 95 %: Wilson's for rates, Student's t for means."""

import math
from statistics import NormalDist, fmean, stdev
from typing import NamedTuple, Sequence

CONFIDENCE = 0.95

_Z = NormalDist().inv_cdf(0.5 + CONFIDENCE / 2)
_MANY = 200  # degrees of freedom


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


def t_quantile(freedom: int) -> float:
    """The t that |T| stays below with the probability of 95 %, T having `freedom` degrees.

    By bisection of Student's distribution, which is a finite sum for whole degrees of freedom
    (Abramowitz and Stegun, 26.7.3 and 26.7.4); for more than 200 by the expansion 26.7.5.
    """
    if freedom > _MANY:
        z, n = _Z, freedom
        first = (z**3 + z) / 4
        second = (5 * z**5 + 16 * z**3 + 3 * z) / 96
        return z + first / n + second / n**2
    low, high = 0.0, 20.0
    for _ in range(100):
        middle = (low + high) / 2
        if _probability(middle, freedom) < CONFIDENCE:
            low = middle
        else:
            high = middle
    return (low + high) / 2


def _probability(t: float, freedom: int) -> float:
    """The probability of |T| < t."""
    angle = math.atan(t / math.sqrt(freedom))
    sine, cosine = math.sin(angle), math.cos(angle)
    if freedom % 2:
        term, total = cosine, 0.0
        for k in range(1, freedom - 1, 2):
            total += term
            term *= cosine * cosine * (k + 1) / (k + 2)
        return 2 / math.pi * (angle + sine * total)
    term, total = 1.0, 0.0
    for k in range(0, freedom - 1, 2):
        total += term
        term *= cosine * cosine * (k + 1) / (k + 2)
    return sine * total
