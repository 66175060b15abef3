"""DiffDrive: odometry with noise and without, its covariances, transform and stamps."""

import numpy as np
import pytest
from readings import FILTERED, GROUND_TRUTH, assert_white, pose_of, twist_of

from flatland_server import LocalTransport, MessageWriter, Publisher
from flatland_server.messages.wire_form import serialized

DRIVE = "type: DiffDrive, name: drive, body: base"


def test_noise_has_the_configured_variances_about_the_truth(files):
    pose_noise, twist_noise = [0.04, 0.01, 0.0025], [0.09, 0.0004, 0.16]
    robot = files.robot(
        f"{DRIVE}, odom_pose_noise: {pose_noise}, odom_twist_noise: {twist_noise}",
        pose="[3, -2, 1]",
        seed=7,
    )

    messages = robot.record(FILTERED, 10.0)

    noise = np.array([[*pose_of(m), *twist_of(m)] for m in messages]) - [3, -2, 1, 0, 0, 0]
    assert len(noise) == 2000
    assert_white(noise, [*pose_noise, *twist_noise])


def test_ground_truth_has_no_noise(files):
    noise = "odom_pose_noise: [1, 1, 1], odom_twist_noise: [1, 1, 1]"
    robot = files.robot(f"{DRIVE}, {noise}", pose="[3, -2, 1]").run()

    truth = robot.last(GROUND_TRUTH)

    assert pose_of(truth) == pytest.approx((3.0, -2.0, 1.0), abs=1e-6)
    assert twist_of(truth) == (0.0, 0.0, 0.0)


def test_covariances_default_to_variances_on_the_diagonal(files):
    robot = files.robot(f"{DRIVE}, odom_pose_noise: [1, 2, 3], odom_twist_noise: [4, 5, 6]").run()

    # x, y, z, roll, pitch, yaw
    for topic in (FILTERED, GROUND_TRUTH):
        message = robot.last(topic)
        assert list(message.pose.covariance) == np.diag([1.0, 2, 0, 0, 0, 3]).ravel().tolist()
        assert list(message.twist.covariance) == np.diag([4.0, 5, 0, 0, 0, 6]).ravel().tolist()


def test_given_covariances_are_sent_as_they_are(files):
    pose, twist = [i / 2 for i in range(36)], [i / 4 for i in range(36)]
    given = f"odom_pose_covariance: {pose}, odom_twist_covariance: {twist}"
    robot = files.robot(f"{DRIVE}, odom_pose_noise: [1, 2, 3], {given}").run()

    message = robot.last(FILTERED)

    assert list(message.pose.covariance) == pose
    assert list(message.twist.covariance) == twist


def test_the_transform_is_the_filtered_odometry(files):
    robot = files.robot(f"{DRIVE}, odom_pose_noise: [1, 1, 1]", pose="[3, -2, 1]").drive(1.0, 1.0)

    robot.run(0.5)

    odometry, transform = robot.last(FILTERED), robot.transport.transforms["base"]
    assert tuple(transform.pose) == pytest.approx(pose_of(odometry), abs=1e-9)
    assert (transform.parent, transform.roll) == (odometry.header.frame_id, 0.0)
    assert transform.nanoseconds == odometry.header.stamp.to_nsec()


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
