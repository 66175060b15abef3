"""Feeder: spawns models, and deletes them when they leave an area."""

from typing import Any, Dict, List

from flatland_server import Pose, Timekeeper, UpdateTimer, WorldPlugin, YamlReader, messages

Int32 = messages.get("std_msgs/Int32")


class Feeder(WorldPlugin):
    """Spawns a model at a rate, deletes those that leave an area, and publishes their number.

    A feeder called `box` names its models, and their namespaces, `box_0`, `box_1` ...
    """

    def on_initialize(self, config: YamlReader) -> None:
        """Reads the model, the pose and the rate [Hz] of spawning, and the area."""
        self._model = config.get_path("model")
        self._pose = config.get_pose("pose", Pose())
        self._area = config.get_floats("area", 4)
        self._timer = UpdateTimer(config.get_rate("spawn_rate", 1.0))
        topic = config.get_topic("topic", f"{self.name}/count")
        if config.is_sound and not self._contains(self._pose):
            config.problem("expected [x_min, y_min, x_max, y_max] around the pose", "area")
        self._publisher = self.node.advertise(topic, "std_msgs/Int32", latch=True)
        self._names: List[str] = []
        self._spawned = 0
        self._published = -1

    def after_physics_step(self, timekeeper: Timekeeper) -> None:
        """Deletes and spawns models; both take effect at the end of the step."""
        models = self.world.models
        there = [name for name in self._names if name in models]  # models may be deleted elsewhere
        self._names = [name for name in there if self._contains(models[name].pose)]
        for name in there:
            if name not in self._names:
                self.world.delete_model(name)

        if self._timer.check_update(timekeeper):
            name = f"{self.name}_{self._spawned}"
            self.world.spawn_model(self._model, name, namespace=name, pose=self._pose)
            self._names.append(name)
            self._spawned += 1

        if len(self._names) != self._published:
            self._published = len(self._names)
            self._publisher.publish(Int32(self._published))

    def get_state(self) -> Dict[str, Any]:
        """The data to keep in a saved state, which contains the models already."""
        return {
            "names": self._names,
            "spawned": self._spawned,
            "published": self._published,
            "timer": self._timer.get_state(),
        }

    def set_state(self, state: Dict[str, Any]) -> None:
        """Called on a new plugin, after `on_initialize`, when a state is loaded."""
        self._names = state["names"]
        self._spawned = state["spawned"]
        self._published = state["published"]
        self._timer.set_state(state["timer"])

    def _contains(self, pose: Pose) -> bool:
        x_min, y_min, x_max, y_max = self._area
        return x_min <= pose.x <= x_max and y_min <= pose.y <= y_max
