"""The keys of a Laser."""

import math
from dataclasses import dataclass, replace
from typing import Optional, Tuple

from flatland_plugins.sensor_frame import read_tf_topic
from flatland_server import Pose, YamlReader

_MAX_BEAMS = 1_000_000


@dataclass(frozen=True)
class LaserConfig:
    """The documented keys, but for bodies; angles in rad, lengths in m."""

    topic: str
    frame: str
    tf_topic: Optional[str]
    origin: Pose
    range: float
    range_min: float
    noise_std_dev: float
    angle_min: float
    increment: float
    beams: int
    update_rate: float
    layers: Tuple[str, ...]
    upside_down: bool
    always_publish: bool
    no_return: float
    """The range of a beam that hits nothing, in messages."""

    @classmethod
    def read(
        cls, config: YamlReader, name: str, no_return: str = "inf", static_tf: bool = False
    ) -> "LaserConfig":
        """Reads all keys but those of bodies.

        Args:
            config: the plugin's entry in the model file.
            name: of the plugin, and the default of its frame.
            no_return: default of the key `no_return`.
            static_tf: default of the key `static_tf`.
        """
        angle = config.get_section("angle", required=True)
        angle_min = angle.get_float("min")
        angle_max = angle.get_float("max")
        increment = angle.get_float("increment")
        if abs(angle_max - angle_min) > math.tau + 0.01:
            turn = f"{math.degrees(angle_max - angle_min):.4g} degrees"
            angle.warn(f"expected angles in rad, found a turn of {turn} from min to max", "max")
        angle.finish()
        laser = cls(
            topic=config.get_topic("topic", "scan"),
            frame=config.get_frame("frame", name),
            tf_topic=read_tf_topic(config, static_tf),
            origin=config.get_pose("origin", Pose()),
            range=config.get_float("range", above=0.0),
            range_min=config.get_float("range_min", 0.0, minimum=0.0),
            noise_std_dev=config.get_float("noise_std_dev", 0.0, minimum=0.0),
            angle_min=angle_min,
            increment=increment,
            beams=count_beams(angle_min, angle_max, increment),
            update_rate=config.get_rate("update_rate", math.inf),
            layers=config.get_strings("layers", ("all",)),
            upside_down=config.get_bool("upside_down", False),
            always_publish=config.get_bool("always_publish", False),
            no_return=math.inf,
        )
        if not laser.layers and config.is_sound:
            config.warn("expected the layers that it sees, found none: it sees nothing", "layers")
        if config.is_sound and laser.range_min >= laser.range:
            expected = f"expected less than the range, {laser.range:g}"
            config.problem(f"{expected}, found {laser.range_min:g}", "range_min")
        word = config.get_choice("no_return", ["inf", "nan", "max"], no_return)
        laser = replace(laser, no_return=laser.range if word == "max" else float(word))
        if config.is_sound and not 1 <= laser.beams <= _MAX_BEAMS:
            config.problem(
                f"expected an increment that leads from min to max in 1 to {_MAX_BEAMS} beams, "
                f"found {increment:g} from {angle_min:g} to {angle_max:g}",
                "angle",
            )
        config.finish()
        return laser


def count_beams(angle_min: float, angle_max: float, increment: float) -> int:
    """The number of beams from min to max; 0 if the increment does not fit.

    The number of steps is rounded, a half upwards: the last beam is up to half a step from max.
    """
    if angle_min == angle_max:
        return 1
    steps = (angle_max - angle_min) / increment if increment else -1.0
    return math.floor(steps + 0.5) + 1 if 0 <= steps < 1e9 else 0
