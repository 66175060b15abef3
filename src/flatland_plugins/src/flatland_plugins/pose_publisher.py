"""PosePublisher: the true pose of a body."""

from flatland_plugins.other_names import given_name
from flatland_server import (
    BatchRole,
    ModelPlugin,
    Pose,
    Timekeeper,
    UpdateTimer,
    YamlReader,
    fill_pose,
    header,
    messages,
)

PoseStamped = messages.get("geometry_msgs/PoseStamped")


class PosePublisher(ModelPlugin):
    """Publishes geometry_msgs/PoseStamped: a body's pose in the world, without noise."""

    batch_role = BatchRole()

    def on_initialize(self, config: YamlReader) -> None:
        self._body = self.get_body(config, default=self.model.base.name)
        topic = config.get_topic(given_name(config, "topic", "ground_truth_pub"), "pose")
        self._frame_id = self.get_frame_id(config, "world_frame_id", "map")
        update_rate = config.get_rate(given_name(config, "update_rate", "pub_rate"), 10.0)
        unused = [key for key in ("odom_frame_id", "odom_pub") if config.has(key)]
        for key in unused:
            config.get_string(key)
        config.finish()

        if unused:
            config.warn(f"no effect: {' and '.join(unused)}")
        self.update_timer = UpdateTimer(update_rate)
        self._publisher = self.node.advertise(topic, "geometry_msgs/PoseStamped")

    def has_work(self) -> bool:
        """True if the topic has a subscriber."""
        return self._publisher.has_subscribers

    def before_physics_step(self, timekeeper: Timekeeper) -> None:
        """Publishes the pose at the start of the step."""
        self.publish_now(timekeeper)

    def publish_now(self, timekeeper: Timekeeper) -> None:
        message = PoseStamped(header=header(timekeeper.nanoseconds, self._frame_id))
        fill_pose(message.pose, self._body.pose)
        self._publisher.publish(message)

    def read(self, timekeeper: Timekeeper) -> Pose:
        """The pose of the body in the world [m, m, rad]."""
        return self._body.pose

    def get_state(self) -> None:
        """Nothing: a pose depends on the present alone."""
