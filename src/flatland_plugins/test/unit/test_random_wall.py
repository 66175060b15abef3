"""RandomWall: the positions and the choice of added walls, and their effects."""

import math
from typing import Any, List, Set, Tuple

import numpy as np
import pytest

from flatland_plugins.random_wall import copies_beside
from flatland_server.exceptions import FlatlandError

ROOM = ("-5 -3 5 -3", "5 -3 5 3", "5 3 -5 3", "-5 3 -5 -3")
COPIES = {  # of the room's walls, 0.5 m inwards
    (-5.0, -2.5, 5.0, -2.5),
    (4.5, -3.0, 4.5, 3.0),
    (5.0, 2.5, -5.0, 2.5),
    (-4.5, 3.0, -4.5, -3.0),
}
OUTER_COPIES = {
    (-5.0, -3.5, 5.0, -3.5),
    (5.5, -3.0, 5.5, 3.0),
    (5.0, 3.5, -5.0, 3.5),
    (-5.5, 3.0, -5.5, -3.0),
}
WALLS = "type: RandomWall, name: chance, layer: walls, robot_name: robot, wall_wall_dist: 0.5"
LASER = "type: Laser, name: laser, body: base, range: 20, angle: {min: -3, max: 3, increment: 0.5}"
PLUGINS_LINE = 9


def room(files, plugin: str, *, segments=ROOM, robot="", pose="[0, 0, 0]", **options: Any):
    """A world with walls, a robot and this plugin of the world."""
    robot = robot or files.model("robot", LASER)
    return files.load(
        f"""
        properties: {{}}
        layers:
          - {{name: [walls, bricks], map: {files.walls("room", *segments)}}}
          - {{name: empty}}
        models:
          - {{name: robot, model: {robot}, pose: {pose}}}
        plugins:
        # a line to count to
          - {{{plugin}}}
        """,
        **options,
    )


def added(world, before: int = len(ROOM)) -> List[Tuple[float, ...]]:
    """The walls of the layer that are not on its map."""
    rows = world.world.get_layer("walls").segments[before:]
    return [tuple(row) for row in rows.round(6).tolist()]


def parallel_offset(original: np.ndarray, copy: np.ndarray) -> float:
    """Distance of a copy to the left of its wall [m]; NaN if not parallel and of equal length."""
    along = original[2:] - original[:2]
    along /= np.linalg.norm(along)
    shifts = copy.reshape(2, 2) - original.reshape(2, 2)
    if not np.allclose(shifts[0], shifts[1], atol=1e-6) or abs(shifts[0] @ along) > 1e-6:
        return math.nan
    return float(along[0] * shifts[0, 1] - along[1] * shifts[0, 0])


# Positions


@pytest.mark.parametrize("count", [0, 1, 2, 3, 4])
@pytest.mark.parametrize("is_double", [False, True])
def test_as_many_walls_are_added_as_asked_for_at_distinct_places(files, count, is_double):
    plugin = f"{WALLS}, num_of_walls: {count}, double_wall: {str(is_double).lower()}"
    copies = added(room(files, plugin))

    inner, outer = [c for c in copies if c in COPIES], [c for c in copies if c in OUTER_COPIES]
    assert len(set(inner)) == len(inner) == count  # on the robot's side
    assert len(set(outer)) == len(outer) == (count if is_double else 0)
    assert len(copies) == len(inner) + len(outer)


@pytest.mark.parametrize(
    ("pose", "copy"),
    [
        ("[0, 0, 0]", (2.0, -1.0, 2.0, 1.0)),
        ("[9, 0, 0]", (4.0, -1.0, 4.0, 1.0)),
        # Beyond its end the wall counts as infinite.
        ("[2.9, 5, 0]", (2.0, -1.0, 2.0, 1.0)),
        ("[3.1, 5, 0]", (4.0, -1.0, 4.0, 1.0)),
    ],
)
@pytest.mark.parametrize("wall", ["3 -1 3 1", "3 1 3 -1"])
def test_the_side_is_that_of_the_robot_at_loading(files, pose, copy, wall):
    plugin = WALLS.replace("0.5", "1") + ", num_of_walls: 1"

    [found] = added(room(files, plugin, segments=(wall,), pose=pose), before=1)

    assert found in (copy, (*copy[2:], *copy[:2]))


def test_copies_are_on_the_side_of_the_place():
    rng = np.random.default_rng(8)
    walls, place = rng.uniform(-5, 5, (500, 4)), np.array([1.0, -2.0])

    copies = copies_beside(walls, place, 0.3, is_double=True)

    near, far = (
        np.array([parallel_offset(each, copy) for each, copy in zip(walls, copies[:, side])])
        for side in (0, 1)
    )
    along = walls[:, 2:] - walls[:, :2]
    to_place = place - walls[:, :2]
    left = np.sign(along[:, 0] * to_place[:, 1] - along[:, 1] * to_place[:, 0])
    assert near == pytest.approx(0.3 * left, abs=1e-9)
    assert far == pytest.approx(-0.3 * left, abs=1e-9)


def test_walls_are_taken_from_all_over_the_layer(files):
    chosen: Set[Tuple[float, ...]] = set()
    for seed in range(30):
        chosen |= set(added(room(files, f"{WALLS}, num_of_walls: 1", seed=seed)))

    # The probability that one of four is left out thirty times is 4 * 0.75^30 < 0.1 %.
    assert chosen == COPIES


# Never on the robot


@pytest.mark.parametrize("seed", range(10))
@pytest.mark.parametrize("double", ["true", "false"])
def test_no_wall_comes_up_on_the_robot(files, seed, double):
    # At 0.55 m from the east wall and 0.65 m from the south wall, with a radius of 0.2 m.
    plugin = f"{WALLS}, num_of_walls: 2, double_wall: {double}"
    world = room(files, plugin, pose="[4.45, -2.35, 0]", seed=seed)

    north_and_west = {(5.0, 2.5, -5.0, 2.5), (-4.5, 3.0, -4.5, -3.0)}
    assert set(added(world)) & COPIES == north_and_west


TAIL = "{name: tail, pose: [-1, 0, 0], footprints: [{type: circle, radius: 0.1, density: 1}]}"


@pytest.mark.parametrize(
    ("footprints", "tail", "farthest"),  # a copy is at x = 2.5; the reach counts in all directions
    [
        ("{type: circle, radius: 0.2, density: 1}", "", 2.3),
        ("{type: circle, center: [0.3, 0.3], radius: 3, density: 1}", "", -0.924),
        ("{type: polygon, points: [[-1, 0], [0.1, -0.1], [0, 0]], density: 1}", "", 1.5),
        ("", TAIL, 1.4),
    ],
)
def test_the_robot_is_as_large_as_its_footprints(files, footprints, tail, farthest):
    robot = files.write(
        "robot.yaml", f"bodies: [{{name: b, footprints: [{footprints}]}}, {tail}]"
    ).name
    free, taken = (
        {"segments": ("3 -2 3 2",), "robot": robot, "pose": f"[{farthest + more}, 0, 2]"}
        for more in (-0.01, 0.01)
    )
    assert added(room(files, f"{WALLS}, num_of_walls: 1", **free), before=1) == [(2.5, -2, 2.5, 2)]
    with pytest.raises(FlatlandError, match="without standing on the robot, found 0"):
        room(files, f"{WALLS}, num_of_walls: 1", **taken)


def test_a_robot_without_any_footprint_is_a_point(files):
    ghost = files.write("ghost.model.yaml", "bodies: [{name: base, footprints: []}]").name

    world = room(files, f"{WALLS}, num_of_walls: 4", robot=ghost)

    assert set(added(world)) == COPIES


def test_a_layer_may_be_named_by_any_of_its_names(files):
    plugin = WALLS.replace("layer: walls", "layer: bricks") + ", num_of_walls: 4"

    assert set(added(room(files, plugin))) == COPIES


def test_two_of_them_put_up_walls_of_their_own(files):
    first = "type: RandomWall, name: a, layer: walls, robot_name: robot, num_of_walls: 4"
    second = f"{first.replace('name: a', 'name: b')}, wall_wall_dist: 0.5"
    plugins = f"{first}, wall_wall_dist: 0.5}}\n          - {{{second}"

    world = room(files, plugins)

    # The second one copies walls of the first as well.
    assert set(added(world)[:4]) == COPIES
    assert len(added(world)) == 8


# Wrong configurations


COPIED = "that can be copied without standing on the robot, found"


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("layer: walls", "layer: wals", 'layer: no layer is named "wals" (did you mean "walls"?)'),
        (": robot", ": robbot", 'robot_name: there is no model "robbot" (did you mean "robot"?)'),
        ("1", "-1", "num_of_walls: expected a whole number of 0 or more, found -1"),
        ("1", "1.5", "num_of_walls: expected a whole number, found 1.5"),
        ("0.5", "0", "wall_wall_dist: expected a number above 0, found 0"),
        ("1", "5", f'num_of_walls: expected 5 walls of the layer "walls" {COPIED} 4'),
        (": walls", ": empty", f'num_of_walls: expected 1 walls of the layer "empty" {COPIED} 0'),
    ],
)
def test_a_wrong_configuration_is_refused_at_its_line(files, old, new, message):
    with pytest.raises(FlatlandError) as caught:
        room(files, f"{WALLS}, num_of_walls: 1".replace(old, new))

    assert f"{files.folder}/world.yaml:{PLUGINS_LINE}: plugins[0].{message}" in str(caught.value)


def test_zero_random_walls_may_be_on_a_layer_without_walls(files):
    plugin = WALLS.replace("layer: walls", "layer: empty")

    assert added(room(files, plugin)) == []
