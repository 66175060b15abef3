"""The scenes of the ray cases: the same walls and bodies in Flatland and in Box2D."""

from pathlib import Path
from typing import TYPE_CHECKING, Any, List, NamedTuple, Tuple

import numpy as np

from flatland2d import Simulation
from flatland_benchmark.outlines import trace_outlines
from flatland_benchmark.robot_worlds import floor
from flatland_server.arrays import FloatArray
from flatland_server.geometry import Pose

if TYPE_CHECKING:
    from flatland_benchmark import _box2d_rays

POSES = 200
"""Number of lidar poses in each scene."""

Shape = Tuple[Any, ...]
"""("circle", center, radius) or ("polygon", vertices), in the body's frame [m]."""


class Body(NamedTuple):
    """A dynamic body at rest."""

    pose: Pose
    footprints: Tuple[Shape, ...]


class Scene:
    """Walls and bodies, and the poses of the lidar.

    Args:
        walls: the map, as in a world file.
        poses: the lidar's poses.
        bodies: the bodies, all of which lidars see.
    """

    def __init__(self, walls: Any, poses: List[Pose], bodies: Tuple[Body, ...] = ()) -> None:
        layers = [{"name": "map", "map": walls}]
        self._simulation = Simulation({"properties": {}, "layers": layers})
        self.world = self._simulation.world
        self.poses = poses
        self.bodies = bodies
        self.segments = np.concatenate([layer.segments for layer in self.world.layers])
        for body in bodies:
            handle = self.world.physics.add_body("dynamic", body.pose)
            for kind, *shape in body.footprints:
                # Without collisions: they may overlap, and stay where they are.
                getattr(handle, f"add_{kind}")(*shape, density=1.0, collides=False)

    def in_box2d(self) -> "List[_box2d_rays.World]":
        """The scene in Box2D, for several orders of insertion: its speed depends on them."""
        outlines = trace_outlines(self.segments)
        longest_first = sorted(outlines, key=len, reverse=True)
        return [self._insert(order) for order in (outlines, outlines[::-1], longest_first)]

    def _insert(self, outlines: List[FloatArray]) -> "_box2d_rays.World":
        from flatland_benchmark import _box2d_rays  # made by catkin; other cases run without it

        world = _box2d_rays.World()
        world.add_walls(np.concatenate(outlines))
        for body in self.bodies:
            index = world.add_body(body.pose)
            for kind, *shape in body.footprints:
                getattr(world, f"add_{kind}")(index, *shape)
        return world


def office(worlds: Path) -> Scene:
    """The office's walls and furniture, from poses anywhere inside."""
    return Scene(str(worlds / "office/office.yaml"), _office_poses(worlds, POSES))


def office_bodies(worlds: Path) -> Scene:
    """Fifty bodies around the office's lobby and the lidar among them."""
    near = [pose for pose in _office_poses(worlds, 20 * POSES) if np.hypot(*pose[:2]) < 8.0]
    bodies = _fifty_bodies(near)
    walls = str(worlds / "office/office.yaml")
    return Scene(walls, _outside(bodies, near[50:])[:POSES], bodies)


def _office_poses(worlds: Path, count: int) -> List[Pose]:
    return _single_precision(floor(worlds, 0.0).poses(count, np.random.default_rng(1)))


def noisy_map(worlds: Path) -> Scene:
    """Rooms of 10 x 10 m in 200 x 200 m, full of single pixels, with 200,000 segments in all."""
    rng, pixel = np.random.default_rng(1), 0.05
    cells = np.zeros((4000, 4000), bool)
    cells[100:3900:200, 100:3900] = True
    cells[100:3900, 100:3900:200] = True
    cells[rng.random(cells.shape) < 0.00319] = True
    poses = rng.uniform((0.0, 0.0, -np.pi), (200.0, 200.0, np.pi), (2 * POSES, 3))
    columns, rows = (poses[:, :2] / pixel).astype(int).T
    free = poses[~cells[rows, columns]][:POSES]
    return Scene({"grid": cells, "resolution": pixel}, _single_precision(free))


def room(worlds: Path) -> Scene:
    """Four walls, 20 x 20 m."""
    return Scene(_ROOM, _room_poses(POSES))


def bodies(worlds: Path) -> Scene:
    """The room with fifty bodies in view."""
    bodies = _fifty_bodies(_room_poses(50))
    return Scene(_ROOM, _outside(bodies, _room_poses(4 * POSES)[50:])[:POSES], bodies)


_ROOM = {"polygons": [[[-10, -10], [10, -10], [10, 10], [-10, 10]]]}


def _room_poses(count: int) -> List[Pose]:
    limits = np.array([9.5, 9.5, np.pi])
    return _single_precision(np.random.default_rng(1).uniform(-limits, limits, (count, 3)))


def _single_precision(poses: FloatArray) -> List[Pose]:
    """Poses, shape (n, 3), rounded, so that all ray casters start at the same point."""
    rounded: List[List[float]] = poses.astype(np.float32).tolist()
    return [Pose(*each) for each in rounded]


_BOX = ("polygon", ((-0.375, -0.25), (0.375, -0.25), (0.375, 0.25), (-0.375, 0.25)))
_WEDGE = ("polygon", ((-0.25, -0.25), (0.375, 0.0), (-0.25, 0.25)))
_TAIL = ("polygon", ((-0.5, -0.125), (-0.25, -0.125), (-0.25, 0.125), (-0.5, 0.125)))
_KINDS: Tuple[Tuple[Shape, ...], ...] = (
    (("circle", (0.0, 0.0), 0.25),),
    (("circle", (0.0, 0.125), 0.0625), ("circle", (0.0, -0.125), 0.0625)),  # a pair of legs
    (_BOX,),
    (_BOX, ("circle", (0.375, 0.0), 0.25)),
    (_WEDGE,),
    (_WEDGE, _TAIL),
)
_FARTHEST = 0.65
"""Greatest distance of a footprint's edge from its body's origin [m]."""


def _fifty_bodies(poses: List[Pose]) -> Tuple[Body, ...]:
    return tuple(Body(pose, _KINDS[i % len(_KINDS)]) for i, pose in enumerate(poses[:50]))


def _outside(bodies: Tuple[Body, ...], poses: List[Pose]) -> List[Pose]:
    """The poses outside all bodies."""
    places = np.array([body.pose[:2] for body in bodies])
    return [pose for pose in poses if np.hypot(*(places - pose[:2]).T).min() > _FARTHEST]
