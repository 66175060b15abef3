"""The scenes of the ray cases. The seed determines the poses of the lidar and the bodies."""

import tempfile
from pathlib import Path
from typing import List, Tuple, Union

import numpy as np
from PIL import Image

from flatland_benchmark.free_poses import free_poses, single_precision
from flatland_benchmark.scene import Body, Circle, Polygon, Scene
from flatland_server.geometry import Pose
from flatland_server.simulation.world import World

POSES = 200
"""Number of lidar poses in each scene."""


def office(worlds: Path, seed: int = 1) -> Scene:
    """The office's walls and furniture, from poses anywhere inside."""
    return Scene(_world_of(worlds / "office/office.yaml"), _office_poses(worlds, POSES, seed))


def office_with_bodies(worlds: Path, seed: int = 1) -> Scene:
    """Fifty bodies around the office's lobby and the lidar among them."""
    near = [pose for pose in _office_poses(worlds, 20 * POSES, seed) if np.hypot(*pose[:2]) < 8.0]
    bodies = _fifty_bodies(near)
    poses = _outside(bodies, near[50:])[:POSES]
    return Scene(_world_of(worlds / "office/office.yaml"), poses, bodies)


def _office_poses(worlds: Path, count: int, seed: int) -> List[Pose]:
    rng = np.random.default_rng(seed)
    return free_poses(worlds / "office/office.yaml", count, rng, reachable_from=(0.0, 0.0))


def noisy_map(worlds: Path, seed: int = 1) -> Scene:
    """Rooms of 10 x 10 m, full of single pixels, with 200,000 segments in all."""
    rng = np.random.default_rng(seed)
    with tempfile.TemporaryDirectory() as folder:
        map_file = write_noisy_map(Path(folder), specks=0.00319)
        return Scene(_world_of(map_file), free_poses(map_file, POSES, rng))


def write_noisy_map(folder: Path, specks: float) -> Path:
    """An image of 200 x 200 m and its map file: rooms, and a share of the pixels black."""
    rng = np.random.default_rng(1)
    pixels = np.full((4000, 4000), 254, np.uint8)
    pixels[100:3900:200, 100:3900] = 0
    pixels[100:3900, 100:3900:200] = 0
    pixels[rng.random(pixels.shape) < specks] = 0
    Image.fromarray(pixels).save(folder / "map.png")
    path = folder / "map.yaml"
    path.write_text("image: map.png\nresolution: 0.05\norigin: [0, 0, 0]\noccupied_thresh: 0.65\n")
    return path


def room(worlds: Path, seed: int = 1) -> Scene:
    """Four walls, 20 x 20 m."""
    return Scene(_empty_room(), _room_poses(POSES, seed))


def room_with_bodies(worlds: Path, seed: int = 1) -> Scene:
    """The room with fifty bodies in view."""
    bodies = _fifty_bodies(_room_poses(50, seed))
    return Scene(_empty_room(), _outside(bodies, _room_poses(4 * POSES, seed)[50:])[:POSES], bodies)


def _empty_room() -> World:
    with tempfile.TemporaryDirectory() as folder:
        Path(folder, "room.dat").write_text(
            "-10 -10 10 -10\n10 -10 10 10\n10 10 -10 10\n-10 10 -10 -10\n"
        )
        path = Path(folder, "room.yaml")
        path.write_text("{type: line_segments, data: room.dat, scale: 1, origin: [0, 0, 0]}")
        return _world_of(path)


def _room_poses(count: int, seed: int) -> List[Pose]:
    rng = np.random.default_rng(seed)
    limits = np.array([9.5, 9.5, np.pi])
    return single_precision(rng.uniform(-limits, limits, (count, 3)))


def _world_of(map_file: Path) -> World:
    """A world of one map and nothing else."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder, "world.yaml")
        path.write_text(f"properties: {{}}\nlayers: [{{name: map, map: {map_file}}}]\n")
        return World.from_file(path)


_BOX = Polygon(((-0.375, -0.25), (0.375, -0.25), (0.375, 0.25), (-0.375, 0.25)))
_WEDGE = Polygon(((-0.25, -0.25), (0.375, 0.0), (-0.25, 0.25)))
_KINDS: Tuple[Tuple[Union[Circle, Polygon], ...], ...] = (
    (Circle((0.0, 0.0), 0.25),),
    (Circle((0.0, 0.125), 0.0625), Circle((0.0, -0.125), 0.0625)),  # a pair of legs
    (_BOX,),
    (_BOX, Circle((0.375, 0.0), 0.25)),
    (_WEDGE,),
    (_WEDGE, Polygon(((-0.5, -0.125), (-0.25, -0.125), (-0.25, 0.125), (-0.5, 0.125)))),
)
_FARTHEST = 0.65
"""Greatest distance of a footprint's edge from its body's origin [m]."""


def _fifty_bodies(poses: List[Pose]) -> Tuple[Body, ...]:
    return tuple(Body(pose, _KINDS[i % len(_KINDS)]) for i, pose in enumerate(poses[:50]))


def _outside(bodies: Tuple[Body, ...], poses: List[Pose]) -> List[Pose]:
    """The poses outside all bodies."""
    places = np.array([body.pose[:2] for body in bodies])
    return [pose for pose in poses if np.hypot(*(places - pose[:2]).T).min() > _FARTHEST]
