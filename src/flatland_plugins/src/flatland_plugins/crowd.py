"""Crowd: people that walk between goals and give way to walls, robots and each other."""

from typing import Dict, List, Sequence

from flatland_plugins.crowd_config import CrowdConfig
from flatland_plugins.people import Person, model_of
from flatland_plugins.timed_noise import draw_key
from flatland_server import (
    BatchRole,
    Model,
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


_TOLERANCE = 1e-5
"""Of the room of a pedestrian [m]: positions in the core are in single precision."""


class Crowd(WorldPlugin):
    """Puts people into the world, each of them a model; the core moves them.

    Between two updates Box2D moves them at their velocities, and resolves collisions: they are
    bodies like others, without a drive. The next update starts from the result.

    Recorded people walk as they were recorded. A body shows one after the other; in between, it is
    far away.
    """

    def on_initialize(self, config: YamlReader) -> None:
        """Reads the keys and puts the people into the world: all of them, or none."""
        self._frame_id = self.get_frame_id(config, "world_frame_id", "map")
        crowd = CrowdConfig.read(config, self.name, self.world.registry, self.world.models)
        walk = crowd.walk
        self.update_timer = UpdateTimer(walk.update_rate)
        self._publisher = self.node.advertise(crowd.poses_pub, "geometry_msgs/PoseArray")
        key = draw_key(self.rng)
        self._varies = crowd.start[0] < crowd.start[1]
        begin = self.rng.uniform(*crowd.start) if self._varies else crowd.start[0]
        self._crowd = self.world.physics.add_crowd(key, begin=begin, **walk.settings)
        self._people: List[Person] = []
        groups: Dict[str, int] = {}
        try:
            for each in crowd.pedestrians:
                model = model_of(each, config.file, walk.layers, walk.layer_bits)
                entry = ModelEntry(each.name, "", each.pose, model)
                person = Person.of(each, self.world.add_model(entry))
                self._people.append(person)
                group = -1 if each.group is None else groups.setdefault(each.group, len(groups))
                person.join(self._crowd, group=group)
            self._before_scatter = None
            if any(person.config.area is not None for person in self._people):
                self._before_scatter = self.world.physics.save_state()
            self._crowd.scatter()
            self._check_room(config)
        except BaseException:
            self.on_shutdown()
            raise

    def _check_room(self, config: YamlReader) -> None:
        """Raises an error if people would start too close to something."""
        for person, distances in zip(self._people, self._crowd.clearances()):
            if person.config.walks:
                continue
            radius = person.config.build.radius
            for what, clearance in zip(("a wall", "a model", "another pedestrian"), distances):
                if clearance < radius - _TOLERANCE:
                    problem = f"expected room for a radius of {radius:g} m, found {what}"
                    after = f"after {max(clearance, 0.0):.2g} m"
                    key = "pose" if person.config.area is None else "area"
                    config.note(person.config.reader.error(f"{problem} {after}", key))
        config.raise_problems()

    @property
    def people(self) -> Sequence[Model]:
        """The models of the people that are there, or will come."""
        return [person.model for person in self._people if self._is_there(person)]

    @property
    def groups(self) -> Sequence[Sequence[Model]]:
        """The people of each group that are there, not away."""
        groups: Dict[str, List[Model]] = {}
        for person in filter(self._is_there, self._people):
            if person.config.group is not None:
                groups.setdefault(person.config.group, []).append(person.model)
        return list(groups.values())

    @property
    def batch_role(self) -> BatchRole:
        """The people, and where they draw their places; worlds differ if their times are drawn."""
        return BatchRole(
            crowd=self._crowd, before_scatter=self._before_scatter, varies_by_seed=self._varies
        )

    def has_work(self) -> bool:
        """True if the topic has a subscriber."""
        return self._publisher.has_subscribers

    def before_physics_step(self, timekeeper: Timekeeper) -> None:
        """Publishes the poses of the people that are there."""
        poses = PoseArray(header=header(timekeeper.nanoseconds, self._frame_id))
        for model in self.people:
            if model.is_away:
                continue
            poses.poses.append(PoseMessage())
            fill_pose(poses.poses[-1], model.pose)
        self._publisher.publish(poses)

    def _is_there(self, person: Person) -> bool:
        return self.world.models.get(person.config.name) is person.model

    def get_state(self) -> None:
        """Nothing: the core keeps the people's progress."""

    def on_shutdown(self) -> None:
        """Deletes the people."""
        self._crowd.remove()
        for person in self._people:
            if self._is_there(person):
                self.world.delete_model(person.config.name)
