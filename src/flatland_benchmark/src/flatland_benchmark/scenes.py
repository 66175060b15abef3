"""The scenes of the ray cases: the same walls and bodies in Flatland and in Box2D."""

import tempfile
from pathlib import Path
from typing import Any, List, NamedTuple, Tuple

import numpy as np
from PIL import Image

from flatland2d import Simulation
from flatland_benchmark import _box2d_rays
from flatland_benchmark.free_space import free_poses, single_precision
from flatland_benchmark.outlines import trace_outlines
from flatland_server.arrays import FloatArray
from flatland_server.geometry import Pose

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
        map_file: the map with the walls.
        poses: the lidar's poses.
        bodies: the bodies, all of which lidars see.
    """

    def __init__(self, map_file: Path, poses: List[Pose], bodies: Tuple[Body, ...] = ()) -> None:
        layers = [{"name": "map", "map": str(map_file)}]
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

    def in_box2d(self) -> List[_box2d_rays.World]:
        """The scene in Box2D, for several orders of insertion: its speed depends on them."""
        outlines = trace_outlines(self.segments)
        longest_first = sorted(outlines, key=len, reverse=True)
        return [self._insert(order) for order in (outlines, outlines[::-1], longest_first)]

    def _insert(self, outlines: List[FloatArray]) -> _box2d_rays.World:
        world = _box2d_rays.World()
        world.add_walls(np.concatenate(outlines))
        for body in self.bodies:
            index = world.add_body(body.pose)
            for kind, *shape in body.footprints:
                getattr(world, f"add_{kind}")(index, *shape)
        return world


def office(worlds: Path) -> Scene:
    """The office's walls and furniture, from poses anywhere inside."""
    return Scene(worlds / "office/office.yaml", _office_poses(worlds, POSES))


def office_bodies(worlds: Path) -> Scene:
    """Fifty bodies around the office's lobby and the lidar among them."""
    near = [pose for pose in _office_poses(worlds, 20 * POSES) if np.hypot(*pose[:2]) < 8.0]
    bodies = _fifty_bodies(near)
    return Scene(worlds / "office/office.yaml", _outside(bodies, near[50:])[:POSES], bodies)


def _office_poses(worlds: Path, count: int) -> List[Pose]:
    return free_poses(worlds / "office/office.yaml", count, seed=1, reachable_from=(0.0, 0.0))


def noisy_map(worlds: Path) -> Scene:
    """Rooms of 10 x 10 m in 200 x 200 m, full of single pixels, with 200,000 segments in all."""
    rng = np.random.default_rng(1)
    pixels = np.full((4000, 4000), 254, np.uint8)
    pixels[100:3900:200, 100:3900] = 0
    pixels[100:3900, 100:3900:200] = 0
    pixels[rng.random(pixels.shape) < 0.00319] = 0
    with tempfile.TemporaryDirectory() as folder:
        Image.fromarray(pixels).save(Path(folder, "map.png"))
        path = Path(folder, "map.yaml")
        path.write_text(
            "{image: map.png, resolution: 0.05, origin: [0, 0, 0], occupied_thresh: 0.65}"
        )
        return Scene(path, free_poses(path, POSES, seed=1))


def room(worlds: Path) -> Scene:
    """Four walls, 20 x 20 m."""
    return _room(_room_poses(POSES))


def bodies(worlds: Path) -> Scene:
    """The room with fifty bodies in view."""
    bodies = _fifty_bodies(_room_poses(50))
    return _room(_outside(bodies, _room_poses(4 * POSES)[50:])[:POSES], bodies)


def _room(poses: List[Pose], bodies: Tuple[Body, ...] = ()) -> Scene:
    with tempfile.TemporaryDirectory() as folder:
        Path(folder, "room.dat").write_text(
            "-10 -10 10 -10\n10 -10 10 10\n10 10 -10 10\n-10 10 -10 -10\n"
        )
        path = Path(folder, "room.yaml")
        path.write_text("{type: line_segments, data: room.dat, scale: 1, origin: [0, 0, 0]}")
        return Scene(path, poses, bodies)


def _room_poses(count: int) -> List[Pose]:
    limits = np.array([9.5, 9.5, np.pi])
    return single_precision(np.random.default_rng(1).uniform(-limits, limits, (count, 3)))


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
