"""ModelTfPublisher: the transforms between a model's bodies, and from the world to the model."""

import math

from flatland_server.geometry import Transform
from flatland_server.model_plugin import ModelPlugin
from flatland_server.timekeeper import Timekeeper
from flatland_server.update_timer import UpdateTimer
from flatland_server.yaml_reader import YamlReader


class ModelTfPublisher(ModelPlugin):
    """Publishes reference -> body for each body, and world -> reference if asked to."""

    def on_initialize(self, config: YamlReader) -> None:
        """Reads the documented keys."""
        self._reference = self.get_body(config, "reference", self.model.base.name)
        self._publish_tf_world = config.get_bool("publish_tf_world", False)
        self._world_frame_id = config.get_string("world_frame_id", "map")
        rate = config.get_rate("update_rate", math.inf)
        excluded = self.get_body_names(config, "exclude")
        config.finish()

        self.update_timer = UpdateTimer(rate)
        self._bodies = [
            body
            for body in self.model.bodies.values()
            if body is not self._reference and body.name not in excluded
        ]
        self._publish_tf_world &= self._reference.name not in excluded
        self._frame = self.name_space_tf(self._reference.name)
        if self._publish_tf_world:
            self.node.claim_frame(self._world_frame_id, self._frame)
        for body in self._bodies:
            self.node.claim_frame(self._frame, self.name_space_tf(body.name))

    def has_work(self) -> bool:
        """Whether anybody listens."""
        return self.node.transforms_are_watched

    def before_physics_step(self, timekeeper: Timekeeper) -> None:
        """Publishes the transforms of now."""
        now = timekeeper.nanoseconds
        pose = self._reference.pose
        if self._publish_tf_world:
            self.node.send_transform(Transform(now, self._world_frame_id, self._frame, pose))
        to_reference = pose.inverse()
        for body in self._bodies:
            child = self.name_space_tf(body.name)
            relative = to_reference.compose(body.pose)
            self.node.send_transform(Transform(now, self._frame, child, relative))
