"""Scans against b2World::RayCast: the same scene, the same poses, the same process, one thread.

Times are processor time of this process, over all its threads: other programs affect them little.
A step, which may move every body, precedes each of our scans; its own time is subtracted.
"""

import time
from pathlib import Path
from statistics import median
from typing import TYPE_CHECKING, Callable, List, Union

import numpy as np

from flatland_benchmark import scenes
from flatland_benchmark.case import Figures, case
from flatland_server._core import BeamFan
from flatland_server.arrays import Float32Array, FloatArray
from flatland_server.geometry import Pose

if TYPE_CHECKING:
    from flatland_benchmark import _box2d_rays

Ranges = Union[FloatArray, Float32Array]
Scan = Callable[[Pose], Ranges]
"""The ranges [m] from a pose."""

_FIRST, _INCREMENT, _BEAMS = -2.356194490192345, 0.004363323129985824, 1081  # 270 degrees
_BLOCK = 10
"""Poses scanned in a row by one ray caster before the other scans them."""
_ROUNDS = 5
_SAME = 1e-3
"""Ranges that differ by no more than this [m] are the same."""


@case(
    "scan_{scene}",
    "rays of {reach:g} m against Box2D's at 200 poses of the scene {scene}",
    scene=("office", "noisy_map", "room", "bodies", "office_bodies"),
    reach=(20.0,),
)
@case(
    "scan_{scene}_far",
    "rays of {reach:g} m, through the whole map",
    scene=("office",),
    reach=(100.0,),
)
def compare(worlds: Path, scene: str, reach: float) -> Figures:
    """Time of a beam in Flatland and in Box2D, and the number of ranges that differ.

    Args:
        worlds: the folder of the package's worlds.
        scene: a function of `scenes`.
        reach: range of the lidar [m], and length of Box2D's rays.
    """
    place: scenes.Scene = getattr(scenes, scene)(worlds)
    fan = BeamFan(_FIRST, _INCREMENT, _BEAMS)
    angles = _FIRST + _INCREMENT * np.arange(_BEAMS)
    directions = np.column_stack([np.cos(angles), np.sin(angles)])

    def ours(pose: Pose) -> Ranges:
        return place.world.physics.scan(fan, pose, reach)[0]

    def step() -> None:
        place.world.physics.step(0.005)

    def by_box2d(world: "_box2d_rays.World") -> Scan:
        return lambda pose: world.scan(directions, pose, reach)

    theirs = _fastest([by_box2d(world) for world in place.in_box2d()], place.poses)
    differing = sum(  # warms both up, too
        np.count_nonzero(~np.isclose(ours(pose), theirs(pose), rtol=0.0, atol=_SAME))
        for pose in place.poses
    )
    blocks = [place.poses[begin : begin + _BLOCK] for begin in range(0, len(place.poses), _BLOCK)]
    pairs = [
        (_beam_time(ours, block, step), _beam_time(theirs, block))
        for _ in range(_ROUNDS)
        for block in blocks
    ]
    return {
        "beam [ns]": median(mine for mine, _ in pairs) * 1e9,
        "Box2D's beam [ns]": median(box2d for _, box2d in pairs) * 1e9,
        "times Box2D": median(box2d / mine for mine, box2d in pairs),
        "rays cast": float(len(place.poses) * _BEAMS),
        "differing rays": float(differing),
    }


def _fastest(scans: List[Scan], poses: List[Pose]) -> Scan:
    """The fastest scan, by the best of several rounds each."""
    few = poses[:: len(poses) // _BLOCK]
    times = [min(_beam_time(scan, few) for _ in range(_ROUNDS)) for scan in scans]
    return scans[times.index(min(times))]


def _beam_time(scan: Scan, poses: List[Pose], before: Callable[[], None] = lambda: None) -> float:
    """Seconds per beam of scans from these poses, without the time of `before`."""
    begin = time.process_time()
    for pose in poses:
        before()
        scan(pose)
    middle = time.process_time()
    for _ in poses:
        before()
    end = time.process_time()
    return ((middle - begin) - (end - middle)) / len(poses) / _BEAMS
