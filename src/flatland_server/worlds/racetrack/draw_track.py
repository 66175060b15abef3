#!/usr/bin/env python3
"""Draws walls.dat, a race track of 80 m: its two walls, at equal distances from a closed curve.

Run it again after a change: ./draw_track.py
"""

from pathlib import Path

import numpy as np

HALF_WIDTH = 1.1  # m
POINTS = 240  # of each wall

# The middle of the track, by its angle from the origin: the radius [m] is a sum of waves.
MEAN, WAVES = 9.5, {2: (2.6, 0.0), 3: (1.5, 0.9), 5: (0.9, 2.2)}  # number: amplitude [m], phase


def middle(angle):
    """Points of the middle of the track, shape (n, 2) [m]."""
    radius = MEAN + sum(size * np.cos(k * angle + phase) for k, (size, phase) in WAVES.items())
    return radius[:, None] * np.column_stack([1.3 * np.cos(angle), 0.8 * np.sin(angle)])


def evenly(count):
    """Points at equal distances along the middle, and the directions to the left of them."""
    fine = middle(np.linspace(0.0, 2.0 * np.pi, 20001))
    way = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(fine, axis=0).T))])
    places = np.linspace(0.0, way[-1], count, endpoint=False)
    points = np.column_stack([np.interp(places, way, fine[:, k]) for k in range(2)])
    ahead = np.roll(points, -1, axis=0) - np.roll(points, 1, axis=0)
    ahead /= np.hypot(*ahead.T)[:, None]
    return points, np.column_stack([-ahead[:, 1], ahead[:, 0]]), way[-1]


def main():
    """Writes the walls, and says how long the track is."""
    points, left, length = evenly(POINTS)
    walls = [points + side * HALF_WIDTH * left for side in (1.0, -1.0)]
    ends = np.vstack([np.hstack([wall, np.roll(wall, -1, axis=0)]) for wall in walls])
    lines = ("{:.3f} {:.3f} {:.3f} {:.3f}\n".format(*each) for each in ends)
    Path(__file__).with_name("walls.dat").write_text("".join(lines))
    x, y = points[0]
    heading = np.arctan2(-left[0, 0], left[0, 1])
    print(f"{length:.1f} m, from [{x:.2f}, {y:.2f}, {heading:.3f}]")


if __name__ == "__main__":
    main()
