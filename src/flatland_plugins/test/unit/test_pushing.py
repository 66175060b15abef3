"""Physics through a world: walls hold, boxes are pushed and come to rest."""

import math

import pytest

DRIVE = "type: DiffDrive, name: drive, body: base"
TURTLEBOT_RADIUS = 0.18


def box(files, name: str, density: float, damping: float = 4.0) -> str:
    """Writes a box of half a metre; returns its file."""
    half = "[[-0.25, -0.25], [0.25, -0.25], [0.25, 0.25], [-0.25, 0.25]]"
    footprint = f"{{type: polygon, points: {half}, density: {density}, friction: 0.3}}"
    body = f"linear_damping: {damping}, angular_damping: {damping},"
    return str(files.model(name, footprint=footprint, body=body))


@pytest.mark.parametrize("heading", [2 * math.pi * i / 30 for i in range(30)])
def test_a_robot_at_2_metres_a_second_does_not_pass_a_wall(empty_room, heading):
    robot = empty_room.model("turtlebot")
    empty_room.world.move_model("turtlebot", robot.pose._replace(yaw=heading))
    empty_room.drive(2.0)

    # To the farthest corner it is 5.8 m, so it pushes against the wall for a while.
    for _ in range(40):
        empty_room.run(0.1)
        x, y, _ = robot.pose
        assert abs(x) < 5.0 - TURTLEBOT_RADIUS + 0.02
        assert abs(y) < 3.0 - TURTLEBOT_RADIUS + 0.02

    touches = max(abs(x) - 5.0, abs(y) - 3.0) > -TURTLEBOT_RADIUS - 0.02
    assert touches
    for wheel in ("left_wheel", "right_wheel"):
        assert math.dist(robot.get_body(wheel).pose[:2], (x, y)) == pytest.approx(0.115, abs=0.01)


def test_a_pushed_box_moves_ahead_of_the_robot(files):
    parcel = box(files, "parcel", density=4)  # 1 kg
    robot = files.robot(DRIVE, others={"parcel": f"model: {parcel}, pose: [1, 0, 0]"}).drive(0.5)

    robot.run(4.0)

    ahead = robot.model("parcel").pose.x - robot.model().pose.x
    assert robot.model().pose.x > 1.0
    assert ahead == pytest.approx(0.2 + 0.25, abs=0.02)
    assert robot.model("parcel").pose[1:] == pytest.approx((0.0, 0.0), abs=0.05)


def test_a_box_against_a_wall_stops_the_robot(files):
    crate = box(files, "crate", density=4000)  # a ton
    wall = f"name: walls, map: {files.walls('wall', '2 -3 2 3')}"
    others = {"crate": f"model: {crate}, pose: [1.75, 0, 0]"}
    robot = files.robot(DRIVE, layers=(wall,), others=others).drive(0.5)

    robot.run(1.0)
    on_its_way = robot.last("/odometry/ground_truth").twist.twist.linear.x
    robot.run(4.0)
    at_the_box = robot.last("/odometry/ground_truth").twist.twist.linear.x

    assert on_its_way == pytest.approx(0.5, abs=1e-3)
    assert at_the_box == pytest.approx(0.0, abs=0.02)
    crate_pose = robot.model("crate").pose
    assert crate_pose.x == pytest.approx(2.0 - 0.25, abs=0.03)
    assert robot.model().pose.x == pytest.approx(crate_pose.x - 0.25 - 0.2, abs=0.02)
