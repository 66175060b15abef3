"""The keys of a Pedestrian."""

import math
import re
from dataclasses import dataclass
from typing import Optional, Sequence

import numpy as np

from flatland_plugins.crowd_config import WALK_RATIO, Attention, Build, PedestrianConfig, WalkConfig
from flatland_plugins.people import LEG_RADIUS, leg_offset
from flatland_server import Circle, Model, ModelBody, YamlReader


@dataclass(frozen=True)
class PedestrianKeys:
    """All keys but those of bodies.

    Attributes:
        walk: how it walks.
        person: where it walks by itself, its speed, its size and its gait.
        leg_radius: of its legs [m].
        swing_radius: of a leg in the middle of its swing [m].
        safety_dist: radius of the circle that is drawn around it [m].
        odom_sub: topic of the Odometry that it follows.
        agent_topic: topic of the AgentStates that it follows; None: it follows none.
        agent_id: its id in AgentStates.
    """

    walk: WalkConfig
    person: PedestrianConfig
    leg_radius: float
    swing_radius: float
    safety_dist: float
    odom_sub: str
    agent_topic: Optional[str]
    agent_id: str

    @classmethod
    def read(
        cls,
        config: YamlReader,
        model: Model,
        legs: Sequence[ModelBody],
        circle: Optional[ModelBody],
    ) -> "PedestrianKeys":
        """Reads the keys.

        Deviations of the gait depend on the name of the model alone: they are the same in each run,
        and in all environments of a batch.

        Args:
            config: the plugin's configuration.
            model: the plugin's model.
            legs: its legs, if it has some.
            circle: the body that is drawn around it, if there is one.
        """
        rng = np.random.default_rng(list(model.name.encode()))

        def vary(key: str, mean: float, least: float) -> float:
            deviation = config.get_float(f"var_{key}", 0.0, minimum=0.0)
            return max(least, mean + deviation * float(rng.standard_normal()))

        walk = WalkConfig.read(config, model.registry)
        goals = config.get_points("goals", 1, 10_000, [model.pose[:2]])
        radius = config.get_float("radius", Build.radius, minimum=0.01)
        speed = config.get_float("speed", Build.speed, above=0.0)
        offset = 2.0 * leg_offset(Build(radius=radius))
        offset = vary("leg_offset", config.get_float("leg_offset", offset, minimum=0.0), 0.0)
        step_time = config.get_float("step_time", math.sqrt(WALK_RATIO / speed), above=0.0)
        step_time = vary("step_time", step_time, 0.1)
        leg_radius = config.get_float(
            "leg_radius", _radius_of(legs, LEG_RADIUS * radius), above=0.0
        )
        leg_radius = vary("leg_radius", leg_radius, 0.01)
        swing_radius = config.get_float("swing_radius", leg_radius, above=0.0)
        if not config.get_bool("toggle_leg_movement", True):
            step_time, swing_radius = 0.0, leg_radius
        around = [circle] if circle is not None else []
        safety_dist = config.get_float("safety_dist", _radius_of(around, radius), above=0.0)
        walk_ratio = speed * step_time**2
        build = Build(speed, radius, bool(legs), leg_offset=offset / 2.0, walk_ratio=walk_ratio)
        number = re.search(r"\d+$", model.name)
        return cls(
            walk=walk,
            person=PedestrianConfig(
                model.name,
                model.pose,
                tuple(goals),
                build,
                config,
                Attention.read(config, Attention()),
            ),
            leg_radius=leg_radius,
            swing_radius=swing_radius,
            safety_dist=safety_dist,
            odom_sub=config.get_topic("odom_sub", "agent"),
            agent_topic=config.get_topic("agent_topic", None),
            agent_id=config.get_string("agent_id", str(int(number.group())) if number else None)
            or model.name,
        )


def _radius_of(bodies: Sequence[ModelBody], default: float) -> float:
    """The radius of the first circle among the footprints of bodies [m]."""
    shapes = [footprint.shape for body in bodies for footprint in body.config.footprints]
    return next((shape.radius for shape in shapes if isinstance(shape, Circle)), default)
