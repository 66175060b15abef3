"""Penner's formulas, as easings.net writes them.

Robert Penner, "Programming Macromedia Flash MX", 2002, chapter 7. `n` is the degree of a power.
"""

import math
from typing import Callable, Dict


def power_in_out(n: int, t: float) -> float:
    return 2 ** (n - 1) * t**n if t < 0.5 else 1 - (-2 * t + 2) ** n / 2


def exponential_in_out(t: float) -> float:
    return 2 ** (20 * t - 10) / 2 if t < 0.5 else (2 - 2 ** (-20 * t + 10)) / 2


def circular_in_out(t: float) -> float:
    if t < 0.5:
        return (1 - math.sqrt(1 - (2 * t) ** 2)) / 2
    return (math.sqrt(1 - (-2 * t + 2) ** 2) + 1) / 2


def back_in_out(t: float) -> float:
    c = 1.70158 * 1.525
    if t < 0.5:
        return (2 * t) ** 2 * ((c + 1) * 2 * t - c) / 2
    return ((2 * t - 2) ** 2 * ((c + 1) * (2 * t - 2) + c) + 2) / 2


def elastic_in_out(t: float) -> float:
    wave = math.sin((20 * t - 11.125) * 2 * math.pi / 4.5)
    return -(2 ** (20 * t - 10)) * wave / 2 if t < 0.5 else 2 ** (-20 * t + 10) * wave / 2 + 1


def bounce_out(t: float) -> float:
    if t < 1 / 2.75:
        return 7.5625 * t * t
    if t < 2 / 2.75:
        return 7.5625 * (t - 1.5 / 2.75) ** 2 + 0.75
    if t < 2.5 / 2.75:
        return 7.5625 * (t - 2.25 / 2.75) ** 2 + 0.9375
    return 7.5625 * (t - 2.625 / 2.75) ** 2 + 0.984375


def bounce_in_out(t: float) -> float:
    return (1 - bounce_out(1 - 2 * t)) / 2 if t < 0.5 else (1 + bounce_out(2 * t - 1)) / 2


PENNER: Dict[str, Callable[[float], float]] = {
    "linear": lambda t: t,
    "quadraticIn": lambda t: t**2,
    "quadraticOut": lambda t: 1 - (1 - t) ** 2,
    "quadraticInOut": lambda t: power_in_out(2, t),
    "cubicIn": lambda t: t**3,
    "cubicOut": lambda t: 1 - (1 - t) ** 3,
    "cubicInOut": lambda t: power_in_out(3, t),
    "quarticIn": lambda t: t**4,
    "quarticOut": lambda t: 1 - (1 - t) ** 4,
    "quarticInOut": lambda t: power_in_out(4, t),
    "quinticIn": lambda t: t**5,
    "quinticOut": lambda t: 1 - (1 - t) ** 5,
    "quinticInOut": lambda t: power_in_out(5, t),
    "exponentialIn": lambda t: 2 ** (10 * t - 10),
    "exponentialOut": lambda t: 1 - 2 ** (-10 * t),
    "exponentialInOut": exponential_in_out,
    "circularIn": lambda t: 1 - math.sqrt(1 - t**2),
    "circularOut": lambda t: math.sqrt(1 - (t - 1) ** 2),
    "circularInOut": circular_in_out,
    "backIn": lambda t: 2.70158 * t**3 - 1.70158 * t**2,
    "backOut": lambda t: 1 + 2.70158 * (t - 1) ** 3 + 1.70158 * (t - 1) ** 2,
    "backInOut": back_in_out,
    "elasticIn": lambda t: -(2 ** (10 * t - 10)) * math.sin((t * 10 - 10.75) * 2 * math.pi / 3),
    "elasticOut": lambda t: 2 ** (-10 * t) * math.sin((t * 10 - 0.75) * 2 * math.pi / 3) + 1,
    "elasticInOut": elastic_in_out,
    "bounceIn": lambda t: 1 - bounce_out(1 - t),
    "bounceOut": bounce_out,
    "bounceInOut": bounce_in_out,
}
"""For 0 < t < 1, in the documentation's order."""
