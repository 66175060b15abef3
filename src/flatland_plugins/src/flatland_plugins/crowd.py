"""Crowd: people that walk between goals and give way to walls, robots and each other."""

from typing import Any, Dict, Iterator, List, Tuple

import numpy as np

from flatland_plugins.crowd_config import CrowdConfig
from flatland_plugins.obstacles import Bodies, Walls, seen_from
from flatland_plugins.pedestrian import Pedestrian, model_of
from flatland_plugins.social_force import Others, discs_apart, limit
from flatland_server import (
    FloatArray,
    ModelEntry,
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

_MOST_SPEED = 1.3
"""Maximum speed over desired speed (Helbing and Molnar, Phys. Rev. E 51, 1995)."""

_REACH = 8.0
"""Reach of walls, in ranges of the repulsion: it has fallen to e^-8 there."""


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
        layers = [layer for layer in self.world.layers if layer.config.bits & crowd.layer_bits]
        radius = max((p.build.radius for p in crowd.pedestrians), default=0.0)
        self._walls = Walls(layers, radius + _REACH * crowd.force.range)
        self._bodies = Bodies(self.world.models, crowd.layer_bits)
        for index, problem in self._tight_places():
            config.note(crowd.pedestrians[index].reader.error(problem, "pose"))
        config.raise_problems()

        self.update_timer = UpdateTimer(crowd.update_rate)
        self._period = self.update_timer.period
        self._publisher = self.node.advertise(crowd.poses_pub, "geometry_msgs/PoseArray")
        self._people: List[Pedestrian] = []
        try:
            for person in crowd.pedestrians:
                model = model_of(person, config.file, crowd.layers, crowd.layer_bits)
                entry = ModelEntry(person.name, "", person.pose, model)
                self._people.append(Pedestrian(person, self.world.add_model(entry)))
        except BaseException:
            self.on_shutdown()
            raise

    def _tight_places(self) -> Iterator[Tuple[int, str]]:
        """The pedestrians that would start too close to something: their indices, and problems."""
        people = self._config.pedestrians
        points = np.array([p.pose[:2] for p in people]).reshape(-1, 2)
        radii = np.array([p.build.radius for p in people])
        apart = discs_apart(points, radii)
        around = {
            "a wall": self._walls.seen_from(points),
            "a model": seen_from(points, self._bodies.find(but=())),
            "another pedestrian": Others(apart.distances + radii[:, np.newaxis], apart.away),
        }
        for what, others in around.items():
            for index, room in enumerate(others.distances.min(axis=1, initial=np.inf)):
                if room < radii[index] - 1e-6:
                    problem = f"expected room for a radius of {radii[index]:g} m, found {what}"
                    yield index, f"{problem} after {max(room, 0.0):.2g} m"

    def before_physics_step(self, timekeeper: Timekeeper) -> None:
        """Publishes the poses, and sets the velocities until the next update."""
        models = self.world.models
        self._people = [p for p in self._people if models.get(p.config.name) is p.model]
        if self._publisher.has_subscribers:
            self._publisher.publish(self._poses(timekeeper.nanoseconds))
        if self._people:
            dt = max(self._period, timekeeper.step_size)
            for person, (vx, vy) in zip(self._people, self._next_velocities(dt).tolist()):
                person.walk(vx, vy, dt)

    def _next_velocities(self, dt: float) -> FloatArray:
        force, people, goal_radius = self._config.force, self._people, self._config.goal_radius
        points = np.array([p.position for p in people])
        velocities = np.array([p.velocity for p in people])
        radii = np.array([p.config.build.radius for p in people])
        speeds = np.array([[p.config.build.speed] for p in people])
        way = np.array([p.way(goal_radius, 2.0 * force.relaxation_time) for p in people])
        will = np.hypot(way[:, :1], way[:, 1:])  # a person that stands neither evades nor sways

        bodies = self._bodies.find(but={p.model for p in people})
        their_velocities = np.array([b.velocity for b in bodies]).reshape(-1, 2)
        to_walls = self._walls.seen_from(points).nearer_by(radii)
        to_bodies = seen_from(points, bodies).nearer_by(radii)
        apart = discs_apart(points, radii)
        own = velocities[:, np.newaxis]
        repulsion = force.repel(apart) + force.repel(to_bodies) + force.repel(to_walls)
        evasion = force.evade(apart, own - velocities)
        evasion += force.evade(to_bodies, own - their_velocities)

        velocities = force.relax(velocities, speeds * way, repulsion + will * evasion, dt)
        velocities += will * force.scatter(velocities.shape, dt, self.rng)
        return limit(velocities, _MOST_SPEED * speeds[:, 0])

    def _poses(self, nanoseconds: int) -> Any:
        poses = PoseArray(header=header(nanoseconds, self._frame_id))
        for person in self._people:
            poses.poses.append(PoseMessage())
            fill_pose(poses.poses[-1], person.model.pose)
        return poses

    def get_state(self) -> Dict[str, Any]:
        """The goal and the stride of each person that is there."""
        models = self.world.models
        people = [p for p in self._people if models.get(p.config.name) is p.model]
        return {person.config.name: person.get_state() for person in people}

    def set_state(self, state: Dict[str, Any]) -> None:
        """Sets what `get_state` has returned."""
        self._people = [person for person in self._people if person.config.name in state]
        for person in self._people:
            person.set_state(state[person.config.name])

    def on_shutdown(self) -> None:
        """Deletes the people."""
        for person in self._people:
            if self.world.models.get(person.config.name) is person.model:
                self.world.delete_model(person.config.name)
