"""ModelTfPublisher: the transforms between a model's bodies, and from the world to the model."""

import math
from typing import Optional, Sequence

from flatland_server import (
    BatchRole,
    ModelPlugin,
    RelativePoses,
    StepMessage,
    Timekeeper,
    UpdateTimer,
    YamlReader,
)


class ModelTfPublisher(ModelPlugin):
    """Publishes reference -> body for each body, and world -> reference if asked to."""

    batch_role = BatchRole()

    def on_initialize(self, config: YamlReader) -> None:
        self._reference = self.get_body(config, "reference", self.model.base.name)
        publish_tf_world = config.get_bool("publish_tf_world", False)
        world_frame_id = self.get_frame_id(config, "world_frame_id", "map")
        rate = config.get_rate("update_rate", math.inf)
        excluded = self.get_body_names(config, "exclude")
        config.finish()

        self.update_timer = UpdateTimer(rate)
        self._bodies = [
            body
            for body in self.model.bodies.values()
            if body is not self._reference and body.name not in excluded
        ]
        frame = self.name_space_tf(self._reference.name)
        self._world_frame = None
        if publish_tf_world and self._reference.name not in excluded:
            self._world_frame = self.node.open_frames((world_frame_id, frame))
        self._world_pose = RelativePoses(None, [self._reference.physics_body])
        self._frames = self.node.open_frames(
            *((frame, self.name_space_tf(body.name)) for body in self._bodies)
        )
        self._poses = RelativePoses(
            self._reference.physics_body, [body.physics_body for body in self._bodies]
        )

    def has_work(self) -> bool:
        """True if transforms have a subscriber."""
        return self.node.transforms_have_subscribers

    def step_messages(self) -> Sequence[Optional[StepMessage]]:
        """All transforms."""
        messages = []
        if self._world_frame is not None:
            messages.append(self._world_frame.step_message(self._world_pose))
        if self._bodies:
            messages.append(self._frames.step_message(self._poses))
        return messages

    def before_physics_step(self, timekeeper: Timekeeper) -> None:
        """Publishes the transforms at the start of the step."""
        now = timekeeper.nanoseconds
        if self._world_frame is not None:
            self._world_frame.send(now, self._world_pose)
        if self._bodies:
            self._frames.send(now, self._poses)

    def get_state(self) -> None:
        """Nothing: transforms depend on the present alone."""
