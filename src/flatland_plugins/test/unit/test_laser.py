"""Laser: every range against the room's geometry, and the visibility of walls and bodies."""

import math
from typing import Any, Tuple
from unittest.mock import Mock

import numpy as np
import pytest

from flatland_plugins.laser_config import count_beams
from flatland_server import Lidar, LocalTransport
from flatland_server.geometry import Pose

ANGLES = "angle: {min: -3, max: 3, increment: 0.05}"
LASER = f"type: Laser, name: laser, body: base, range: 20, {ANGLES}"
AHEAD = "type: Laser, name: laser, body: base, range: 20, angle: {min: 0, max: 0, increment: 1}"
ROOM = ("-5 -3 5 -3", "5 -3 5 3", "5 3 -5 3", "-5 3 -5 -3")


def distance_to_the_walls(x: float, y: float, angle: float) -> float:
    """The distance from a point in a room of 10 x 6 m about the origin, along an angle."""
    cos, sin = math.cos(angle), math.sin(angle)
    across = (math.copysign(5.0, cos) - x) / cos if cos else math.inf
    along = (math.copysign(3.0, sin) - y) / sin if sin else math.inf
    return min(across, along)


def room_ranges(pose: Tuple[float, float, float], angles: np.ndarray) -> np.ndarray:
    """The ranges of a lidar in the room."""
    x, y, yaw = pose
    return np.array([distance_to_the_walls(x, y, yaw + angle) for angle in angles])


def in_the_room(files, *plugins: str, **options: Any):
    """A robot in the room of 10 x 6 m."""
    layer = f"name: walls, map: {files.walls('room', *ROOM)}"
    return files.robot(*plugins, layers=(layer,), **options)


def beam_angles(scan: Any) -> np.ndarray:
    return scan.angle_min + scan.angle_increment * np.arange(len(scan.ranges))


@pytest.mark.parametrize(
    "pose", [(0.0, 0.0, 0.0), (2.0, -1.0, 0.7), (-4.0, 2.5, -2.0), (4.7, -2.7, 3.1)]
)
def test_the_turtlebot_measures_the_test_room(empty_room, pose):
    empty_room.world.move_model("turtlebot", Pose(*pose))
    empty_room.run()

    scan = empty_room.last("/scan")

    # 270 degrees in steps of a quarter of one, from 5 cm before the robot's middle
    angles = np.radians(np.arange(1081) * 0.25 - 135.0)
    x, y = Pose(*pose).apply(0.05, 0.0)
    assert np.asarray(scan.ranges) == pytest.approx(room_ranges((x, y, pose[2]), angles), abs=1e-3)
    assert beam_angles(scan) == pytest.approx(angles, abs=1e-9)
    assert (scan.range_min, scan.range_max) == (0.0, 20.0)
    assert scan.scan_time == pytest.approx(0.1)


@pytest.mark.parametrize("angle", [(-3, 3, 0.05), (2, -2, -0.1)])
def test_the_lidar_sits_at_its_origin_on_the_body(files, angle):
    laser = LASER.replace(ANGLES, "angle: {{min: {}, max: {}, increment: {}}}".format(*angle))
    point = "{type: circle, radius: 0.01, density: 1}"
    laser += ", origin: [0.5, -0.25, 1]"
    robot = in_the_room(files, laser, pose="[1, 2, 0.5]", footprint=point)

    scan = robot.run().last("/scan")

    x, y = Pose(1.0, 2.0, 0.5).apply(0.5, -0.25)
    expected = room_ranges((x, y, 1.5), beam_angles(scan))
    assert np.asarray(scan.ranges) == pytest.approx(expected, abs=1e-3)
    assert (scan.angle_min, scan.angle_max, scan.angle_increment) == pytest.approx(angle)


def test_upside_down_the_scan_is_mirrored_and_the_frame_rolled(files):
    laser = LASER + ", upside_down: true, origin: [0.1, 0, 0.2]"
    robot = in_the_room(files, laser, pose="[1, 2, 0]")

    scan = robot.run().last("/scan")

    expected = room_ranges((1.1, 2.0, 0.2), -beam_angles(scan))
    assert np.asarray(scan.ranges) == pytest.approx(expected, abs=1e-3)
    assert (scan.angle_min, scan.angle_increment) == (-3.0, 0.05)
    transform = robot.transport.transforms["laser"]
    assert tuple(transform.pose) == (0.1, 0.0, 0.2)
    assert transform.roll == pytest.approx(math.pi)


def test_noise_has_the_configured_deviation(files):
    quiet = in_the_room(files, LASER).run().last("/scan")
    noisy = in_the_room(files, LASER + ", noise_std_dev: 0.05", seed=3)

    scans = noisy.record("/scan", 0.1)

    noise = (np.array([scan.ranges for scan in scans]) - quiet.ranges).ravel() / 0.05
    assert len(noise) == 20 * 121
    # Chi-squared: n squares of standard normals are n +- sqrt(2 n).
    assert abs((noise**2).sum() - len(noise)) < 4 * math.sqrt(2 * len(noise))
    assert abs(noise.sum()) < 4 * math.sqrt(len(noise))


def test_noise_keeps_ranges_in_bounds_and_infinity_infinite(files):
    short = LASER.replace("range: 20", "range: 4.3")
    quiet = np.asarray(in_the_room(files, short).run().last("/scan").ranges)
    noisy = in_the_room(files, f"{short}, noise_std_dev: 3", seed=3)

    ranges = np.array([scan.ranges for scan in noisy.record("/scan", 0.1)])

    nothing = np.isinf(quiet)
    assert nothing.any()
    assert (ranges[:, nothing] == math.inf).all()
    returns = ranges[:, ~nothing]
    assert (returns.min(), returns.max()) == (0.0, np.float32(4.3))


@pytest.mark.parametrize(("word", "value"), [("nan", math.nan), ("max", 4.3), ("inf", math.inf)])
def test_a_beam_without_a_return_has_the_chosen_range(files, word, value):
    short = LASER.replace("range: 20", "range: 4.3") + ", noise_std_dev: 0.5"
    usual = np.asarray(in_the_room(files, short).run().last("/scan").ranges)
    missed = np.isinf(usual)

    other = LocalTransport({"~no_return": "nan" if word == "max" else "max"})
    by_key = in_the_room(files, f"{short}, no_return: {word}", transport=other).run()
    transport = LocalTransport({"~no_return": word})
    by_server = in_the_room(files, short, transport=transport).run()

    assert 0 < missed.sum() < len(missed)
    for simulation in (by_key, by_server):
        ranges = np.asarray(simulation.last("/scan").ranges)
        assert ranges[missed] == pytest.approx(np.full(missed.sum(), value), nan_ok=True)
        assert (ranges[~missed] == usual[~missed]).all()


@pytest.mark.parametrize(
    ("angle_min", "angle_max", "increment", "beams"),
    [
        pytest.param(-2.356194490192345, 2.356194490192345, 0.004363323129985824, 1081, id="270"),
        pytest.param(0.0, 1.0, 0.3, 4, id="the last one stays short of the end"),
        pytest.param(0.0, 1.0, 0.1, 11, id="0.1 is not a tenth in binary"),
        pytest.param(1.0, 1.0, 0.0, 1, id="one without increment"),
        pytest.param(0.0, 1.0, 2.1, 1, id="increment far beyond the end"),
        pytest.param(0.0, 55.25, 0.1, 554, id="half a step is rounded upwards"),
        pytest.param(0.0, 55.24, 0.1, 553, id="552.4 steps"),
        pytest.param(1.0, 0.0, 0.1, 0, id="the wrong way"),
        pytest.param(0.0, 1.0, 0.0, 0, id="no increment"),
        # As `rostopic echo` or a datasheet writes them: pi / 180 and pi / 720 with six digits.
        pytest.param(-3.14159, 3.14159, 0.0174533, 361, id="360 rounded"),
        pytest.param(-2.35619, 2.35619, 0.00436332, 1081, id="270 rounded"),
    ],
)
def test_beams_are_counted_from_min_to_max(angle_min, angle_max, increment, beams):
    assert count_beams(angle_min, angle_max, increment) == beams


@pytest.mark.parametrize(
    ("laser", "seen"),
    [
        ("", 3.0),
        (", layers: [walls]", 3.0),
        (", layers: [more_walls]", 3.0),
        (", layers: all", 3.0),
        (", layers: [other]", math.inf),
        (", layers: [other, walls]", 3.0),
        (", layers: []", math.inf),
    ],
)
def test_a_lidar_sees_the_walls_of_its_layers(files, laser, seen):
    wall = f"name: [walls, more_walls], map: {files.walls('wall', '3 -1 3 1')}"
    robot = files.robot(AHEAD + laser, layers=(wall, "name: other")).run()

    assert robot.last("/scan").ranges == pytest.approx([seen])


def test_things_on_the_layer_reflectance_have_an_intensity(files):
    walls = (
        f"name: plain, map: {files.walls('plain', '2 -1 2 1')}",
        f"name: [reflectance, foil], map: {files.walls('foil', '-1 2 1 2')}",
    )
    target = files.model(
        "target", footprint="{type: circle, radius: 0.5, density: 1, layers: [foil, plain]}"
    )
    mirror = files.model(
        "mirror", footprint="{type: circle, radius: 0.5, density: 1, layers: [reflectance]}"
    )
    right_angles = "angle: {min: -1.5707963, max: 3.1415926, increment: 1.5707963}"
    robot = files.robot(
        LASER.replace(ANGLES, right_angles),
        layers=walls,
        others={
            "target": f"model: {target}, pose: [0, -2, 0]",
            "mirror": f"model: {mirror}, pose: [-2, 0, 0]",
        },
        footprint="{type: circle, radius: 0.1, density: 1}",
    ).run()

    scan = robot.last("/scan")

    assert list(scan.ranges) == pytest.approx([1.5, 2.0, 2.0, 1.5], abs=1e-5)
    assert list(scan.intensities) == [0.0, 0.0, 255.0, 255.0]


@pytest.mark.parametrize(("name", "count"), [("foil", 0), ("reflectance", 121)])
def test_there_are_no_intensities_without_a_layer_reflectance(files, name, count):
    walls = f"name: walls, map: {files.walls('room', *ROOM)}"
    robot = files.robot(LASER, layers=(walls, f"name: {name}")).run()

    scan = robot.last("/scan")

    assert len(scan.ranges) == 121
    assert list(scan.intensities) == [0.0] * count


@pytest.mark.parametrize(("flag", "scans"), [("", 0), (", always_publish: true", 10)])
def test_it_scans_for_subscribers_only_unless_told_otherwise(
    files, monkeypatch, no_subscribers, flag, scans
):
    scan = Mock(wraps=Lidar.scan)
    monkeypatch.setattr(Lidar, "scan", lambda lidar: scan(lidar))
    robot = files.robot(f"{LASER}, update_rate: 10{flag}", transport=no_subscribers)

    robot.run(1.0)

    assert scan.call_count == scans
    assert no_subscribers.transforms == {}
