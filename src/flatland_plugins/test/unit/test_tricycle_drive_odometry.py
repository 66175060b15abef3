"""TricycleDrive: odometry, its topics and frames."""

import math

import pytest
from forklift import WHEELBASE, forklift, twist_at
from logged import warnings
from readings import FILTERED, GROUND_TRUTH, pose_of, twist_of

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


FROM_THE_WORLD = (
    "plugins:",
    "plugins:\n  - {type: ModelTfPublisher, name: tf, publish_tf_world: true}",
)


def parent_of_the_base(robot) -> str:
    return str(robot.transport.transforms["base"].parent)


def test_by_default_the_world_can_be_the_parent_of_its_body(files, caplog):
    robot = forklift(files, replaced=FROM_THE_WORLD).run(0.1)

    assert parent_of_the_base(robot) == "map"
    assert warnings(caplog) == []


def test_the_transform_is_published_if_it_is_asked_for(files):
    robot = forklift(files, "enable_odom_tf_pub: true").drive(0.8, 0.5).run(1.0)

    assert parent_of_the_base(robot) == "odom"
    transform = robot.transport.transforms["base"]
    assert tuple(transform.pose) == pytest.approx(pose_of(robot.last(FILTERED)), abs=1e-9)
