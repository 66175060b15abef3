"""TricycleDrive: odometry, its topics and frames."""

import math

import pytest
from forklift import WHEELBASE, forklift, twist_at
from readings import FILTERED, GROUND_TRUTH, TWIST, pose_of, twist_of

from flatland_server.geometry import Pose


def test_odometry_is_that_of_the_body_at_the_front_wheel(files):
    robot = forklift(files, entry=", pose: [1, 2, 0.5]").drive(0.8, 0.5).run(2.0)

    truth, filtered = robot.last(GROUND_TRUTH), robot.last(FILTERED)

    assert twist_of(truth) == pytest.approx(twist_at(0.8, 0.5), abs=1e-3)
    assert twist_of(filtered) == twist_of(truth)
    robot.run()
    assert pose_of(robot.last(GROUND_TRUTH)) == pytest.approx(pose_of(truth), abs=1.5 * 0.8 * 0.005)
    x, y, _ = pose_of(truth)
    # About the centre of the turn, L / sin a from the front wheel.
    centre = Pose(1.0, 2.0, 0.5).apply(-WHEELBASE, WHEELBASE / math.tan(0.5))
    assert math.dist((x, y), centre) == pytest.approx(WHEELBASE / math.sin(0.5), abs=1e-3)


def test_the_twist_is_published_if_it_is_asked_for(files):
    robot = forklift(files, "enable_twist_pub: true").drive(0.8, 0.5).run(0.1)

    twist = robot.last(TWIST)

    assert robot.transport.topics == {FILTERED, GROUND_TRUTH, TWIST}
    assert twist.header.frame_id == "base"
    assert twist_of(twist) == pytest.approx(twist_at(0.8, 0.5), abs=1e-3)
