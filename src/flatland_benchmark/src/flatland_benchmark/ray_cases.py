"""Scans against b2World::RayCast: the same scene, the same poses, the same process, one thread.

Times are processor time of this process, over all its threads: other programs affect them little.
A step, which may move every body, precedes each of our scans; its own time is subtracted.
"""

import time
from functools import partial
from pathlib import Path
from statistics import median
from typing import Callable, List, Tuple, Union

import numpy as np

from flatland_benchmark import _box2d_rays, scenes
from flatland_benchmark.case import Case, Figures
from flatland_benchmark.scene import Scene
from flatland_server._core import BeamFan
from flatland_server.arrays import Float32Array, FloatArray
from flatland_server.geometry import Pose

Ranges = Union[FloatArray, Float32Array]
Scan = Callable[[Pose], Ranges]
"""The ranges [m] from a pose."""

_FIRST, _INCREMENT, _BEAMS = -2.356194490192345, 0.004363323129985824, 1081  # 270 degrees
_BLOCK = 10
"""Poses scanned in a row by one ray caster before the other scans them."""
_ROUNDS = 5
_SAME = 1e-3
"""Ranges that differ by no more than this [m] are the same."""


def compare(build: Callable[[Path], Scene], reach: float, worlds: Path) -> Figures:
    """Time of a beam in Flatland and in Box2D, and the number of ranges that differ.

    Args:
        build: makes the scene.
        reach: range of the lidar [m], and length of Box2D's rays.
        worlds: the folder of the package's worlds.
    """
    scene = build(worlds)
    fan = BeamFan(_FIRST, _INCREMENT, _BEAMS)
    angles = _FIRST + _INCREMENT * np.arange(_BEAMS)
    directions = np.column_stack([np.cos(angles), np.sin(angles)])

    def ours(pose: Pose) -> Ranges:
        return scene.world.physics.scan(fan, pose, reach)[0]

    def step() -> None:
        scene.world.physics.step(0.005)

    def by_box2d(world: _box2d_rays.World) -> Scan:
        return lambda pose: world.scan(directions, pose, reach)

    theirs = _fastest([by_box2d(world) for world in scene.in_box2d()], scene.poses)
    scans = [(ours(pose), theirs(pose)) for pose in scene.poses]  # warms both up, too
    differing, worse = differences(scene, angles, reach, scans)
    pairs = [
        (_beam_time(ours, block, step), _beam_time(theirs, block))
        for _ in range(_ROUNDS)
        for block in _blocks(scene.poses)
    ]
    beam = median(mine for mine, _ in pairs)
    return {
        "beam [ns]": beam * 1e9,
        "Box2D's beam [ns]": median(box2d for _, box2d in pairs) * 1e9,
        "times Box2D": median(box2d / mine for mine, box2d in pairs),
        "rays [million/s]": 1e-6 / beam,
        "rays cast": float(len(scans) * _BEAMS),
        "differing rays": float(differing),
        "worse than Box2D's": float(worse),
        "segments": float(len(scene.segments)),
    }


def _blocks(poses: List[Pose]) -> List[List[Pose]]:
    return [poses[begin : begin + _BLOCK] for begin in range(0, len(poses), _BLOCK)]


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


def differences(
    scene: Scene, angles: FloatArray, reach: float, scans: List[Tuple[Ranges, Ranges]]
) -> Tuple[int, int]:
    """Number of ranges that differ from Box2D's, and of those where Box2D is more exact."""
    poses = np.array(scene.poses)
    ours, theirs = (np.array(ranges, dtype=np.float64) for ranges in zip(*scans))
    scan, beam = np.nonzero(_error(ours, theirs) > _SAME)
    headings = poses[scan, 2] + angles[beam]
    exact = scene.exact_distances(
        poses[scan, :2], np.column_stack([np.cos(headings), np.sin(headings)])
    )
    exact[exact > reach] = np.inf
    our_error, their_error = (_error(each[scan, beam], exact) for each in (ours, theirs))
    return len(scan), int(np.count_nonzero(our_error > their_error))


def _error(a: FloatArray, b: FloatArray) -> FloatArray:
    """Absolute difference of ranges; infinite where just one of them is."""
    with np.errstate(invalid="ignore"):
        return np.where(a == b, 0.0, np.abs(a - b))


def _case(name: str, build: Callable[[Path], Scene], what: str, reach: float = 20.0) -> Case:
    return Case(name, f"{what}; 1081 beams of {reach:g} m", partial(compare, build, reach))


RAY_CASES = (
    _case("scan_office", scenes.office, "rays against Box2D's at 200 free poses in the office"),
    _case("scan_office_far", scenes.office, "the same through the whole map", 100.0),
    _case("scan_noisy_map", scenes.noisy_map, "rays against Box2D's among 200,000 segments"),
    _case("scan_room", scenes.room, "rays against Box2D's in an empty room of 20 x 20 m"),
    _case("scan_bodies", scenes.room_with_bodies, "the room with 50 moving bodies in view"),
    _case("scan_office_bodies", scenes.office_with_bodies, "the lobby with 50 moving bodies"),
)
