"""DiffDrive: which topics and frames it has, how they are named, and what is refused."""

import pytest
from readings import FILTERED, GROUND_TRUTH, TWIST

DRIVE = "type: DiffDrive, name: drive, body: base"


@pytest.mark.parametrize(
    ("flag", "topics", "frames"),
    [
        ("", {FILTERED, GROUND_TRUTH, TWIST}, {"base"}),
        (", enable_odom_pub: false", {TWIST}, {"base"}),
        (", enable_twist_pub: false", {FILTERED, GROUND_TRUTH}, {"base"}),
        (", enable_odom_tf_pub: false", {FILTERED, GROUND_TRUTH, TWIST}, set()),
    ],
)
def test_flags_switch_topics_and_the_transform_off(files, flag, topics, frames):
    robot = files.robot(DRIVE + flag).run()

    assert robot.transport.topics == topics
    assert set(robot.transport.transforms) == frames
    assert all(robot.last(topic) is not None for topic in topics)


def test_frames_and_topics_are_the_documented_ones(files):
    robot = files.robot(DRIVE).run()

    filtered, truth, twist = (robot.last(topic) for topic in (FILTERED, GROUND_TRUTH, TWIST))
    assert (filtered.header.frame_id, filtered.child_frame_id) == ("odom", "base")
    assert (truth.header.frame_id, truth.child_frame_id) == ("map", "base")
    assert twist.header.frame_id == "base"
    assert robot.transport.subscribed == {"/cmd_vel"}


def test_frames_and_topics_can_be_named(files):
    robot = files.robot(
        f"{DRIVE}, twist_sub: go, odom_pub: a, ground_truth_pub: b, twist_pub: c, "
        "odom_frame_id: start, ground_truth_frame_id: world"
    ).run()

    assert robot.transport.subscribed == {"/go"}
    assert robot.transport.topics == {"/a", "/b", "/c"}
    assert robot.last("/a").header.frame_id == "start"
    assert robot.last("/b").header.frame_id == "world"
    assert robot.transport.transforms["base"].parent == "start"


def test_a_namespace_is_put_before_topics_and_the_models_own_frames(files):
    robot = files.robot(DRIVE, namespace="robot1").drive(1.0, topic="/robot1/cmd_vel").run(1.0)

    assert robot.transport.topics == {f"/robot1{t}" for t in (FILTERED, GROUND_TRUTH, TWIST)}
    odometry = robot.last(f"/robot1{FILTERED}")
    assert (odometry.header.frame_id, odometry.child_frame_id) == ("odom", "robot1_base")
    assert robot.transport.transforms["robot1_base"].parent == "odom"
    assert robot.model().pose.x == pytest.approx(1.0, abs=1e-3)


def test_an_absolute_topic_is_outside_of_the_namespace(files):
    robot = files.robot(f"{DRIVE}, twist_sub: /cmd_vel, twist_pub: /twist", namespace="robot1")

    robot.drive(1.0, topic="/cmd_vel").run(1.0)

    assert robot.transport.subscribed == {"/cmd_vel"}
    assert "/twist" in robot.transport.topics
    assert robot.model().pose.x == pytest.approx(1.0, abs=1e-3)


def test_nothing_is_published_that_nobody_listens_to(files, deaf_transport):
    files.robot(DRIVE, transport=deaf_transport).drive(1.0).run(0.1)

    assert deaf_transport.published == []
    assert deaf_transport.transforms == {}


@pytest.mark.parametrize(
    ("drive", "message"),
    [
        pytest.param(
            "type: DiffDrive, name: drive",
            'plugins[0] "drive": the required key "body" is missing',
            id="body missing",
        ),
        pytest.param(
            "type: DiffDrive, name: drive, body: bas",
            'plugins[0].body: the model has no body "bas" (did you mean "base"?); it has: base',
            id="unknown body",
        ),
        pytest.param(
            f"{DRIVE}, linear_dynamics: {{acceleration_limt: 1}}",
            'plugins[0].linear_dynamics: unknown key "acceleration_limt" '
            '(did you mean "acceleration_limit"?)',
            id="unknown limit",
        ),
        pytest.param(
            f"{DRIVE}, angular_dynamics: {{velocity_limit: -1}}",
            "plugins[0].angular_dynamics.velocity_limit: expected a number of 0 or more, found -1",
            id="negative limit",
        ),
        pytest.param(
            f"{DRIVE}, angular_dynamic: {{velocity_limit: 1}}",
            'plugins[0] "drive": unknown key "angular_dynamic" (did you mean "angular_dynamics"?)',
            id="unknown key",
        ),
        pytest.param(
            f"{DRIVE}, pub_rate: 0",
            "plugins[0].pub_rate: expected a number above 0, found 0",
            id="rate of zero",
        ),
        pytest.param(
            f"{DRIVE}, odom_pose_noise: [0, 0, -1]",
            "plugins[0].odom_pose_noise: expected a list of 3 numbers of 0 or more, "
            "found [0, 0, -1]",
            id="negative variance",
        ),
        pytest.param(
            f"{DRIVE}, odom_twist_covariance: [1, 2, 3]",
            "plugins[0].odom_twist_covariance: expected a list of 36 numbers, found [1, 2, 3]",
            id="short covariance",
        ),
        pytest.param(
            f"{DRIVE}, enable_odom_pub: perhaps",
            'plugins[0].enable_odom_pub: expected true or false, found "perhaps"',
            id="no flag",
        ),
    ],
)
def test_a_wrong_configuration_is_refused_at_its_line(files, drive, message):
    assert files.refusal(drive) == f"robot.model.yaml:5: {message}"
