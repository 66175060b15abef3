"""Crowd: people before a laser, as discs and on two legs that walk."""

import math
from typing import Any, List, Tuple

import numpy as np
import pytest
from townspeople import CALM, RADIUS, SPEED, position, robot

LASER = (
    "type: Laser, name: laser, body: base, range: 5, "
    "angle: {min: -0.3, max: 0.3, increment: 0.0005}"
)


def seen(town: Any) -> List[List[Tuple[float, float]]]:
    """The beams of the robot's laser (angle, range), split at beams that hit nothing."""
    scan = town.run().last("/scan")
    clusters: List[List[Tuple[float, float]]] = [[]]
    for index, distance in enumerate(scan.ranges):
        if math.isinf(distance):
            clusters.append([])
        else:
            clusters[-1].append((scan.angle_min + index * scan.angle_increment, distance))
    return [cluster for cluster in clusters if cluster]


def distance_to_disc(x: float, y: float, radius: float, angle: float) -> float:
    """The distance from the origin to a disc, along an angle."""
    along = x * math.cos(angle) + y * math.sin(angle)
    across = x * math.sin(angle) - y * math.cos(angle)
    return along - math.sqrt(max(0.0, radius**2 - across**2))


def test_a_laser_sees_a_person_as_a_disc(town, files):
    people = town("pose: [2, 0.1, 0]", robots=robot(files, LASER))

    (disc,) = seen(people)

    bearing, half_width = math.atan2(0.1, 2.0), math.asin(RADIUS / math.hypot(2.0, 0.1))
    assert (disc[0][0], disc[-1][0]) == pytest.approx(
        (bearing - half_width, bearing + half_width), abs=1e-3
    )
    for angle, distance in disc[2:-2]:
        assert distance == pytest.approx(distance_to_disc(2.0, 0.1, RADIUS, angle), abs=1e-3)


@pytest.mark.parametrize(
    ("yaw", "radius", "legs"),
    [
        pytest.param(0.0, 0.25, [(2.0, -0.1), (2.0, 0.1)], id="facing away"),
        pytest.param(math.pi / 4, 0.25, [(2.0707, -0.0707), (1.9293, 0.0707)], id="aslant"),
        pytest.param(0.0, 0.3, [(2.0, -0.12), (2.0, 0.12)], id="large"),
    ],
)
def test_a_laser_sees_a_person_with_legs_as_two_small_discs(town, files, yaw, radius, legs):
    person = f"pose: [2, 0, {yaw}], legs: true, radius: {radius}"
    people = town(person, robots=robot(files, LASER))

    clusters = seen(people)

    assert len(clusters) == 2
    for cluster, (x, y) in zip(clusters, legs):
        for angle, distance in cluster[2:-2]:
            expected = distance_to_disc(x, y, 0.28 * radius, angle)
            assert distance == pytest.approx(expected, abs=1e-3)
        middle = (cluster[0][0] + cluster[-1][0]) / 2
        assert middle == pytest.approx(math.atan2(y, x), abs=1e-3)


def test_feet_alternate_and_steps_have_human_length(town):
    people = town("pose: [0, 0, 0], goals: [[100, 0], [0, 0]], legs: true", keys=CALM).run(4.0)
    legs = [people.model("people_0").bodies[name] for name in ("left_leg", "right_leg")]

    path = np.array([[leg.pose[:2] for leg in legs] for _ in range(600) if people.run()])

    # step / (steps per second) = 0.384 m s at any speed, so step^2 = 0.384 speed
    step = math.sqrt(0.384 * SPEED)
    speeds = np.diff(path[..., 0], axis=0) / 0.005
    is_still = np.abs(speeds) < 0.05
    assert is_still.any(axis=1).mean() > 0.8
    assert not is_still.all(axis=1).any()
    for foot in range(2):
        assert speeds[:, foot].max() == pytest.approx(2 * SPEED, rel=0.02)
        stands = np.unique(np.round(path[1:, foot, 0][is_still[:, foot]], 1))
        places = stands[np.insert(np.diff(stands) > 0.2, 0, True)]
        assert np.diff(places) == pytest.approx(np.full(len(places) - 1, 2 * step), abs=0.11)
    assert np.abs(path[:, :, 1] - [0.1, -0.1]).max() < 2e-3


def test_legs_come_along_wherever_the_body_goes_and_end_abreast(town):
    people = town("pose: [0, 0, 0], goals: [[3, 1]], legs: true")

    for _ in range(2000):
        people.run()
        x, y = position(people)
        for name in ("left_leg", "right_leg"):
            assert math.dist((x, y), people.model("people_0").bodies[name].pose[:2]) < 0.5
    body = people.model("people_0").pose

    for name, side in (("left_leg", 0.1), ("right_leg", -0.1)):
        foot = people.model("people_0").bodies[name].pose
        assert foot[:2] == pytest.approx(body.apply(0.0, side), abs=0.03)
