"""Robots in simulated worlds, driven to goals: the office's, and rooms with obstacles."""

import math
from pathlib import Path

import numpy as np
import pytest
from driving import Driver, drive, walls_of

from flatland_navigation.grid import Grid
from flatland_navigation.navigator import Navigator, NavigatorConfig, Status
from flatland_server import Pose, World
from flatland_server.testing import Harness, WorldFiles

pytestmark = pytest.mark.slow

OFFICE = Path(__file__).resolve().parents[3] / "flatland_server" / "worlds" / "office"
ROBOT = OFFICE / "turtlebot.model.yaml"
BOX = OFFICE / "box.model.yaml"
CLEARANCE = 0.25  # m


def grid_of(simulation):
    return Grid.from_walls(walls_of(simulation), CLEARANCE)


def corridor(**models):
    """A robot at (-4, 0), looking east, in a room of 10 x 2.4 m, and further models."""
    return room(robot={"model": str(ROBOT), "pose": [-4, 0, 0]}, **models)


def room(**models):
    files = WorldFiles()
    corners = [(-5, -1.2), (5, -1.2), (5, 1.2), (-5, 1.2)]
    walls = files.walls("map", *[(*a, *b) for a, b in zip(corners, corners[1:] + corners[:1])])
    return files.load_models(models, [{"name": "map", "map": walls}]).run(0.2)


def at_goal(driver, goal):
    error = math.remainder(driver.pose.yaw - goal.yaw, math.tau)
    return math.dist(driver.pose[:2], goal[:2]) <= 0.1 and abs(error) <= 0.1


def positions(simulation):
    return {name: model.pose[:2] for name, model in simulation.world.models.items()}


def test_the_offices_robot_drives_to_three_goals():
    """Past a box in the corridor, through a door, and back; it pushes nothing."""
    simulation = Harness(World.from_file(OFFICE / "world.yaml"))
    boxes = {n: p for n, p in positions(simulation).items() if n.startswith("box")}
    driver = Driver(simulation, grid_of(simulation))

    for goal in (Pose(8.0, 0.0, 0.0), Pose(14.0, -5.0, -1.57), Pose(0.0, 4.0, 1.57)):
        driver.navigator.set_goal(goal)
        drive(simulation, driver)
        assert driver.navigator.status is Status.SUCCEEDED, driver.navigator.text
        assert at_goal(driver, goal)

    for name, position in boxes.items():
        assert math.dist(simulation.model(name).pose[:2], position) < 1e-6


def test_two_robots_in_namespaces_pass_each_other():
    robots = {
        "r1": {"model": str(ROBOT), "namespace": "r1", "pose": [-4.0, 0.1, 0.0]},
        "r2": {"model": str(ROBOT), "namespace": "r2", "pose": [4.0, -0.1, 3.14]},
    }
    simulation = room(**robots)
    grid = grid_of(simulation)
    first, second = (Driver(simulation, grid, name) for name in robots)

    first.navigator.set_goal(Pose(4.0, 0.0, 0.0))
    second.navigator.set_goal(Pose(-4.0, 0.0, math.pi))
    drive(simulation, first, second)

    assert first.navigator.status is Status.SUCCEEDED, first.navigator.text
    assert second.navigator.status is Status.SUCCEEDED, second.navigator.text
    assert at_goal(first, Pose(4.0, 0.0, 0.0))
    assert at_goal(second, Pose(-4.0, 0.0, math.pi))


def test_an_obstacle_across_the_way_stops_it_before_contact():
    row = {f"box{i}": {"model": str(BOX), "pose": [0, -0.9 + 0.6 * i, 0]} for i in range(4)}
    simulation = corridor(**row)
    before = positions(simulation)
    driver = Driver(simulation, grid_of(simulation))
    driver.navigator.set_goal(Pose(4.0, 0.0, 0.0))

    seconds = drive(simulation, driver)

    assert driver.navigator.status is Status.ABORTED
    assert "no progress for 10 s, an obstacle is in its way" in driver.navigator.text
    assert seconds < 30.0
    after = positions(simulation)
    assert all(math.dist(before[name], after[name]) < 1e-6 for name in row)
    gap = -0.25 - (after["robot"][0] + 0.18)
    assert 0.05 <= gap < 0.1


def test_it_drives_on_when_the_way_is_free_again():
    row = {f"box{i}": {"model": str(BOX), "pose": [0, -0.9 + 0.6 * i, 0]} for i in range(4)}
    simulation = corridor(**row)
    driver = Driver(simulation, grid_of(simulation))
    driver.navigator.set_goal(Pose(4.0, 0.0, 0.0))
    for _ in range(2400):  # 12 s
        simulation.run()
        driver.step()
    assert driver.navigator.status is Status.ACTIVE

    for name in row:
        simulation.world.delete_model(name)
    drive(simulation, driver)

    assert driver.navigator.status is Status.SUCCEEDED, driver.navigator.text


@pytest.mark.parametrize("y", [-0.3, 0.0, 0.25])
def test_it_drives_around_an_obstacle_that_is_not_on_the_map(y):
    simulation = corridor(box={"model": str(BOX), "pose": [0, y, 0.5]})
    driver = Driver(simulation, grid_of(simulation))
    driver.navigator.set_goal(Pose(4.0, 0.0, 0.0))

    drive(simulation, driver)

    assert driver.navigator.status is Status.SUCCEEDED, driver.navigator.text
    assert simulation.model("box").pose[:2] == pytest.approx((0, y), abs=1e-6)


def test_a_robot_that_does_not_move_is_stuck():
    navigator = Navigator(grid_of(corridor()), NavigatorConfig(stuck_after=5.0))
    navigator.set_goal(Pose(3.0, 0.0, 0.0))

    times = [i * 0.05 for i in range(200)]
    active = [t for t in times if navigator.update(Pose(-3.0, 0.0), t).forwards > 0.0]

    assert navigator.status is Status.ABORTED
    assert navigator.text == "stuck at (-3.00, 0.00): no progress for 5 s, it does not move"
    assert 4.9 <= active[-1] <= 5.0


def test_a_stuck_robot_gives_up_even_when_a_replan_is_due():
    config = NavigatorConfig(stuck_after=1.0, replan_after=1.0)
    navigator = Navigator(grid_of(corridor()), config)
    navigator.set_goal(Pose(3.0, 0.0, 0.0))

    for time in np.arange(0.0, 1.3, 0.1):
        navigator.observe(np.array([[-2.77, 0.0]]), time)
        command = navigator.update(Pose(-3.0, 0.0), time)
        assert command == (0.0, 0.0)

    assert navigator.status is Status.ABORTED
    assert "an obstacle is in its way" in navigator.text


@pytest.mark.parametrize(
    ("goal", "reason"),
    [(Pose(20.0, 0.0), "outside of the map"), (Pose(4.9, 0.0), "0.10 m from a wall")],
)
def test_a_goal_that_cannot_be_reached_is_refused(goal, reason):
    navigator = Navigator(grid_of(corridor()), NavigatorConfig())
    navigator.set_goal(goal)

    assert navigator.update(Pose(), 1.0) == (0.0, 0.0)
    assert navigator.status is Status.ABORTED
    assert reason in navigator.text


def test_a_goal_may_be_replaced_and_canceled():
    navigator = Navigator(grid_of(corridor()), NavigatorConfig())
    navigator.set_goal(Pose(3.0, 0.0))
    assert navigator.update(Pose(0.0, 0.0, 0.0), 1.0).forwards > 0.0
    assert navigator.path.tolist() == [[0.0, 0.0], [3.0, 0.0]]

    navigator.set_goal(Pose(-3.0, 0.0))
    assert navigator.update(Pose(0.0, 0.0, 0.0), 1.05).forwards == 0.0  # it turns
    assert navigator.path.tolist() == [[0.0, 0.0], [-3.0, 0.0]]

    navigator.cancel()
    assert navigator.status is Status.IDLE
    assert len(navigator.path) == 0
    assert navigator.update(Pose(), 1.1) == (0.0, 0.0)


def test_time_that_begins_anew_does_not_make_it_give_up():
    navigator = Navigator(grid_of(corridor()), NavigatorConfig())
    navigator.set_goal(Pose(3.0, 0.0))
    navigator.update(Pose(0.0, 0.0, 0.0), 1000.0)
    navigator.observe(np.array([[0.3, 0.0]]), 1000.0)

    commands = [navigator.update(Pose(0.0, 0.0, 0.0), 0.05 * i) for i in range(3)]

    assert navigator.status is Status.ACTIVE
    assert commands[-1].forwards > 0.0
