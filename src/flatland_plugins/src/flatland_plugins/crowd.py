"""Crowd: people that walk between goals and give way to walls, robots and each other."""

from typing import Any, Dict, Iterator, List, Sequence, Tuple

import numpy as np

from flatland_plugins.crowd_config import CrowdConfig
from flatland_plugins.crowd_motion import CrowdMotion, poses_of, reach_of
from flatland_plugins.obstacles import Bodies, Outline, Walls, seen_from
from flatland_plugins.people import Person, model_of
from flatland_plugins.social_force import Others, discs_apart
from flatland_server import (
    BatchRole,
    ModelEntry,
    Segments,
    Timekeeper,
    UpdateTimer,
    WorldPlugin,
    YamlReader,
    fill_pose,
    header,
    messages,
)

PoseMessage = messages.get("geometry_msgs/Pose")
PoseArray = messages.get("geometry_msgs/PoseArray")


class Crowd(WorldPlugin):
    """Puts people into the world, each of them a model, and moves them.

    Between two updates Box2D moves them at their velocities, and resolves collisions: they are
    bodies like others, without a drive. The next update starts from the result.
    """

    def on_initialize(self, config: YamlReader) -> None:
        """Reads the keys and puts the people into the world: all of them, or none."""
        self._frame_id = self.get_frame_id(config, "world_frame_id", "map")
        crowd = self._config = CrowdConfig.read(
            config, self.name, self.world.registry, self.world.models
        )
        walk = crowd.walk
        layers = [layer for layer in self.world.layers if layer.config.bits & walk.layer_bits]
        self._reach = reach_of([person.build for person in crowd.pedestrians], walk.force)
        self._walls = Walls(lambda: [layer.segments for layer in layers], self._reach)
        self._bodies = Bodies(self.world.models.values, walk.layer_bits)
        for index, problem in self._tight_places():
            config.note(crowd.pedestrians[index].reader.error(problem, "pose"))
        config.raise_problems()

        self.update_timer = UpdateTimer(walk.update_rate)
        self._publisher = self.node.advertise(crowd.poses_pub, "geometry_msgs/PoseArray")
        self._people: List[Person] = []
        try:
            for person in crowd.pedestrians:
                model = model_of(person, config.file, walk.layers, walk.layer_bits)
                entry = ModelEntry(person.name, "", person.pose, model)
                self._people.append(Person.of(person, self.world.add_model(entry)))
        except BaseException:
            self.on_shutdown()
            raise
        self._motion = self._make_motion(1)
        self._motion.begin(0, self.rng, None)

    def _tight_places(self) -> Iterator[Tuple[int, str]]:
        """The pedestrians that would start too close to something: their indices, and problems."""
        people = self._config.pedestrians
        points = np.array([p.pose[:2] for p in people]).reshape(-1, 2)
        radii = np.array([p.build.radius for p in people])
        apart, bodies = discs_apart(points, radii), self._bodies.find(but=())
        standing = poses_of([each.body for each in bodies])
        around = {
            "a wall": self._walls.seen_from(points),
            "a model": seen_from(points, bodies, np.repeat(standing, len(points), axis=0)),
            "another pedestrian": Others(apart.distances + radii[:, np.newaxis], apart.away),
        }
        for what, others in around.items():
            for index, room in enumerate(others.distances.min(axis=1, initial=np.inf)):
                if room < radii[index] - 1e-6:
                    problem = f"expected room for a radius of {radii[index]:g} m, found {what}"
                    yield index, f"{problem} after {max(room, 0.0):.2g} m"

    def before_physics_step(self, timekeeper: Timekeeper) -> None:
        """Publishes the poses, and sets the velocities until the next update."""
        self._keep([index for index, each in enumerate(self._people) if self._is_there(each)])
        if self._publisher.has_subscribers:
            self._publisher.publish(self._message(timekeeper.nanoseconds))
        if self._people:
            self._motion.see(self._find_others())
            self._motion.update_alone(timekeeper.step_size)

    @property
    def batch_role(self) -> BatchRole:
        """The people's motion."""
        return BatchRole(make_motion=self._make_motion)

    def _make_motion(self, count: int) -> CrowdMotion:
        others = self._find_others()
        walk = self._config.walk
        return CrowdMotion(walk, self._walls, self._see_walls, self._people, others, count)

    def _see_walls(self, walls: Sequence[Segments]) -> Walls:
        """The walls on the crowd's layers, given the walls of each layer of the world."""
        layers = zip(walls, self.world.layers)
        seen = [each for each, layer in layers if layer.config.bits & self._config.walk.layer_bits]
        return Walls(lambda: seen, self._reach)

    def _find_others(self) -> List[Outline]:
        """The present bodies of all models but the people."""
        return self._bodies.find(but={person.model for person in self._people})

    def _is_there(self, person: Person) -> bool:
        return self.world.models.get(person.config.name) is person.model

    def _keep(self, indices: List[int]) -> None:
        """Drops all people but these."""
        if len(indices) < len(self._people):
            self._people = [self._people[index] for index in indices]
            self._motion.keep(indices)

    def _message(self, nanoseconds: int) -> Any:
        poses = PoseArray(header=header(nanoseconds, self._frame_id))
        for person in self._people:
            poses.poses.append(PoseMessage())
            fill_pose(poses.poses[-1], person.model.pose)
        return poses

    def get_state(self) -> Dict[str, Any]:
        """The goal and the stride of each person that is there."""
        names = {person.config.name for person in self._people if self._is_there(person)}
        state = self._motion.get_state(0).items()
        return {name: each for name, each in state if name in names}

    def set_state(self, state: Dict[str, Any]) -> None:
        self._keep([i for i, each in enumerate(self._people) if each.config.name in state])
        self._motion.set_state(0, state)

    def on_shutdown(self) -> None:
        """Deletes the people."""
        for person in self._people:
            if self._is_there(person):
                self.world.delete_model(person.config.name)
