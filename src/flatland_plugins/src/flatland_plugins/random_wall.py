"""RandomWall: walls that are not on the map."""

import numpy as np

from flatland_server import (
    BatchRole,
    FlatlandError,
    FloatArray,
    Segments,
    WorldPlugin,
    YamlReader,
    from_segments,
)


class RandomWall(WorldPlugin):
    """Adds copies of walls of a layer, each beside its original, when the world is loaded.

    The walls are chosen at random, by the world's seed. A copy is parallel to its wall, at the
    distance `wall_wall_dist`, on the side of the robot; a double wall has one on the other side
    too. No copy is placed where the robot stands.
    """

    batch_role = BatchRole(varies_by_seed=True)

    def on_initialize(self, config: YamlReader) -> None:
        """Reads the keys and adds the walls."""
        layer_name = config.get_string("layer")
        count = config.get_int("num_of_walls", 0, minimum=0)
        distance = config.get_float("wall_wall_dist", 1.0, above=0.0)
        is_double = config.get_bool("double_wall", False)
        robot_name = config.get_string("robot_name")
        config.finish()
        try:
            layer = self.world.get_layer(layer_name)
        except FlatlandError as error:
            raise config.error(str(error), "layer") from None
        try:
            robot = self.world.get_model(robot_name)
        except FlatlandError as error:
            raise config.error(str(error), "robot_name") from None

        place = np.array(robot.pose[:2])
        copies = copies_beside(layer.segments, place, distance, is_double)
        away = from_segments(place[np.newaxis], copies.reshape(-1, 4))
        distances = np.hypot(away[..., 0], away[..., 1]).reshape(copies.shape[:2])
        is_free = distances.min(axis=1) > robot.radius
        candidates = np.flatnonzero(is_free)
        if len(candidates) < count:
            raise config.error(
                f'expected {count} walls of the layer "{layer_name}" that can be copied without '
                f"standing on the robot, found {len(candidates)}",
                "num_of_walls",
            )
        chosen = self.rng.choice(candidates, count, replace=False)
        self.world.add_walls(layer_name, copies[chosen].reshape(-1, 4))

    def get_state(self) -> None:
        """Nothing: the walls are added when the world is made, and are then a part of it."""


def copies_beside(walls: Segments, place: FloatArray, distance: float, is_double: bool) -> Segments:
    """Parallels of walls (n, 4) on the side of a place (2,): (n, 1, 4), or (n, 2, 4) on both."""
    start, end = walls[:, :2], walls[:, 2:]
    along = (end - start) / np.linalg.norm(end - start, axis=1, keepdims=True)
    left = np.stack([-along[:, 1], along[:, 0]], axis=1)
    side = np.where(((place - start) * left).sum(axis=1, keepdims=True) >= 0.0, 1.0, -1.0)
    shift = np.tile(distance * side * left, 2)
    copies = [walls + shift, walls - shift] if is_double else [walls + shift]
    return np.stack(copies, axis=1)
