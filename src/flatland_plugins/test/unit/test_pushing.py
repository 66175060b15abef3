"""Physics through a world: walls hold what is on their layers, and boxes are pushed."""

import math

import pytest

DRIVE = "type: DiffDrive, name: drive, body: base"


TURTLEBOT_RADIUS = 0.18


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


@pytest.mark.parametrize(("density", "stops"), [(4, False), (4000, True)])  # 1 kg; a ton
def test_a_box_is_pushed_and_one_against_a_wall_stops_the_robot(files, density, stops):
    half = "[[-0.25, -0.25], [0.25, -0.25], [0.25, 0.25], [-0.25, 0.25]]"
    footprint = f"{{type: polygon, points: {half}, density: {density}, friction: 0.3}}"
    box = files.model("box", footprint=footprint, body="linear_damping: 4, angular_damping: 4,")
    walls, others = ["2 -3 2 3"] if stops else [], {"box": f"model: {box}, pose: [1.75, 0, 0]"}
    robot = files.robot(DRIVE, walls=walls, others=others).drive(0.5)

    speeds = [robot.run(s).last("/odometry/ground_truth").twist.twist.linear.x for s in (1.0, 4.0)]

    assert speeds == pytest.approx([0.5, 0.0 if stops else 0.5], abs=0.02)
    at, pushed = robot.model().pose, robot.model("box").pose
    assert pushed.x - at.x == pytest.approx(0.2 + 0.25, abs=0.02)
    assert pushed[1:] == pytest.approx((0.0, 0.0), abs=0.05)
    if stops:
        assert pushed.x == pytest.approx(2.0 - 0.25, abs=0.03)


@pytest.mark.parametrize(
    ("footprint", "stops"),
    [
        pytest.param("friction: 0", True, id="all layers by default"),
        pytest.param("layers: all", True, id="all layers"),
        pytest.param("layers: [walls]", True, id="the layer's"),
        pytest.param("layers: walls", True, id="the layer's, as a text"),
        pytest.param("layers: [bricks]", True, id="the layer's by its second name"),
        pytest.param("layers: [other, walls]", True, id="the layer's and another"),
        pytest.param("layers: [other]", False, id="another"),
        pytest.param("layers: []", False, id="none"),
        pytest.param("collision: false", False, id="collision switched off"),
        pytest.param("sensor: true", False, id="a sensor"),
    ],
)
def test_a_wall_stops_the_footprints_of_its_layers(files, footprint, stops):
    layers = (f"name: [walls, bricks], map: {files.walls('wall', '2 -3 2 3')}", "name: other")

    disc = f"{{type: circle, radius: 0.2, density: 10, {footprint}}}"

    robot = files.robot(DRIVE, footprint=disc, layers=layers).drive(1.0).run(4.0)

    assert robot.model().pose.x == pytest.approx(1.8 if stops else 4.0, abs=0.02)
