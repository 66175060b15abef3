"""DiffDrive: motion by command and within limits; odometry with noise and without."""

import math
from typing import Tuple

import numpy as np
import pytest
from logged import warnings
from readings import FILTERED, GROUND_TRUTH, assert_white, pose_of, twist_of

from flatland_server import LocalTransport, MessageWriter, Publisher
from flatland_server.messages.wire_form import serialized

DRIVE = "type: DiffDrive, name: drive, body: base"


def arc(linear: float, angular: float, time: float) -> Tuple[float, float, float]:
    """The pose after driving at a constant velocity from the origin, in closed form."""
    turned = angular * time
    if angular == 0.0:
        return linear * time, 0.0, 0.0
    radius = linear / angular
    heading = math.remainder(turned, math.tau)
    return radius * math.sin(turned), radius * (1 - math.cos(turned)), heading


@pytest.mark.parametrize(
    ("linear", "angular"), [(0.3, 0.0), (0.5, 0.4), (-0.3, 0.3), (0.4, -0.5), (0.0, 2.0)]
)
def test_the_last_command_holds_and_leads_along_its_arc(empty_room, linear, angular):
    empty_room.drive(linear, angular)

    truth = empty_room.record(GROUND_TRUTH, 10.0)

    for message in truth[1:]:
        time = message.header.stamp.to_sec()
        x, y, yaw = arc(linear, angular, time)
        assert pose_of(message)[:2] == pytest.approx((x, y), abs=1e-3)
        assert math.remainder(pose_of(message)[2] - yaw, math.tau) == pytest.approx(0.0, abs=1e-3)
        assert twist_of(message) == pytest.approx((linear, 0.0, angular), abs=1e-3)


@pytest.mark.parametrize(
    ("key", "command", "component"),
    [("linear_dynamics", (2.0, 0.0), 0), ("angular_dynamics", (0.0, -2.0), 2)],
)
def test_dynamics_limits_bound_the_velocity(files, key, command, component):
    limits = "{acceleration_limit: 2, deceleration_limit: 1, velocity_limit: 0.5}"
    robot = files.robot(f"{DRIVE}, {key}: {limits}").drive(*command)
    sign = math.copysign(1.0, sum(command))

    messages = robot.record(GROUND_TRUTH, 1.0)
    robot.drive(0.0, 0.0)
    messages += robot.record(GROUND_TRUTH, 1.5)

    times = [message.header.stamp.to_sec() for message in messages]
    expected = [min(0.5, 2 * t) if t <= 1 else max(0.0, 0.5 - (t - 1)) for t in times]
    speeds = [sign * twist_of(message)[component] for message in messages]
    assert speeds == pytest.approx(expected, abs=1e-3)


def test_closing_a_drive_without_its_body_causes_no_warning(files, caplog):
    robot = files.robot(DRIVE).drive(0.5).run(1.0)

    robot.model().base.physics_body.remove()
    robot.world.close()

    assert warnings(caplog) == []


@pytest.mark.parametrize(("linear", "angular"), [(1e39, 0.0), (0.0, 1e300), (-1e300, 1.0)])
def test_a_command_beyond_float32_does_not_stall_the_robot(files, linear, angular):
    robot = files.robot(DRIVE).drive(linear, angular).run(0.1)

    robot.world.move_model("robot", robot.model().pose._replace(x=0.0, y=0.0, yaw=0.0))
    robot.drive(1.0).run(1.0)

    assert robot.model().pose == pytest.approx((1.0, 0.0, 0.0), abs=1e-2)


def test_noise_has_the_configured_variances_about_the_truth(files):
    pose_noise, twist_noise = [0.04, 0.01, 0.0025], [0.09, 0.0004, 0.16]
    noise = f"odom_pose_noise: {pose_noise}, odom_twist_noise: {twist_noise}"
    robot = files.robot(f"{DRIVE}, {noise}", pose="[3, -2, 1]", seed=7)

    messages = robot.record(FILTERED, 10.0)

    noise = np.array([[*pose_of(m), *twist_of(m)] for m in messages]) - [3, -2, 1, 0, 0, 0]
    assert len(noise) == 2000
    assert_white(noise, [*pose_noise, *twist_noise])
    truth = robot.last(GROUND_TRUTH)
    assert (*pose_of(truth), *twist_of(truth)) == pytest.approx((3, -2, 1, 0, 0, 0), abs=1e-6)
    for message in (truth, messages[-1]):
        for part, (x, y, yaw) in ((message.pose, pose_noise), (message.twist, twist_noise)):
            assert list(part.covariance) == np.diag([x, y, 0, 0, 0, yaw]).ravel().tolist()


def test_given_covariances_are_sent_as_they_are(files):
    pose, twist = [i / 2 for i in range(36)], [i / 4 for i in range(36)]
    given = f"odom_pose_covariance: {pose}, odom_twist_covariance: {twist}"
    robot = files.robot(f"{DRIVE}, odom_pose_noise: [1, 2, 3], {given}").run()

    message = robot.last(FILTERED)

    assert list(message.pose.covariance) == pose
    assert list(message.twist.covariance) == twist


class BothForms(LocalTransport):
    """Keeps each message that a writer makes as an object and as bytes."""

    def __init__(self) -> None:
        super().__init__()
        self.written = []

    def advertise(self, topic: str, message_type, *, latch: bool, queue_size: int) -> Publisher:
        publisher = super().advertise(topic, message_type, latch=latch, queue_size=queue_size)

        def write(writer: MessageWriter, *values) -> None:
            self.written.append((topic, writer.message(*values), writer.data(*values)))

        publisher.write = write
        return publisher


@pytest.mark.parametrize(
    "keys",
    [
        "odom_frame_id: odöm",
        "twist_in_local_frame: false",
        "twist_in_local_frame: false, odom_twist_noise: [4, 5, 6]",
        "odom_drift: [1, 1, 1]",
    ],
)
def test_its_bytes_are_those_of_the_messages(files, keys):
    transport = BothForms()
    robot = files.robot(f"{DRIVE}, {keys}", pose="[3, -2, 9]", transport=transport)

    robot.drive(1.0, 2.0).run(1.0)

    for topic in (FILTERED, GROUND_TRUTH, "/twist"):
        made = [each[1:] for each in transport.written if each[0].strip("/") == topic.strip("/")]
        assert len(made) == 200
        for sequence, (message, data) in enumerate(made, 1):
            message.header.seq = sequence
            assert serialized(message) == data
        assert len({data for _, data in made}) == 200
