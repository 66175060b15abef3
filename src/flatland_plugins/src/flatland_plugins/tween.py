"""Tween: a body that moves between two poses by the clock."""

from typing import Any

from flatland_server import EASINGS, TWEEN_MODES, BatchRole, ModelPlugin, YamlReader


class Tween(ModelPlugin):
    """Moves a body from its pose at the start by a delta in the world's frame; the core moves it.

    In mode trigger, std_msgs/Bool selects the direction: to the end (true) or to the start.
    """

    batch_role = BatchRole()

    def on_initialize(self, config: YamlReader) -> None:
        """Reads the documented keys; opens the topic if the mode needs it."""
        trigger_topic = config.get_topic("trigger_topic", "tween_trigger")
        duration = config.get_float("duration", 1.0, above=0.0)
        delta = config.get_pose("delta", is_motion=True)
        body = self.get_body(config)
        mode = config.get_choice("mode", TWEEN_MODES, "yoyo")
        easing = config.get_choice("easing", EASINGS, "linear")
        config.finish()

        self._tween = body.physics_body.add_tween(delta, duration, mode, easing)
        if mode == "trigger":
            self.node.subscribe(trigger_topic, "std_msgs/Bool", self._on_trigger)

    def _on_trigger(self, message: Any) -> None:
        self._tween.trigger(message.data)

    def get_state(self) -> None:
        """Nothing: the core keeps the phase."""
