"""Pedestrian: a model that walks, on legs if it has some."""

import contextlib
import logging
import math
from dataclasses import astuple
from typing import Any, Dict, List, Optional, Sequence

from flatland_plugins.agents import FARTHEST, Agent, from_agent_states, from_odometry
from flatland_plugins.crowd_motion import CrowdMotion, reach_of
from flatland_plugins.obstacles import Outline, Surroundings
from flatland_plugins.other_names import given_name
from flatland_plugins.pedestrian_config import PedestrianKeys
from flatland_plugins.people import LEAST_SPEED, LEGS, Person, leg_offset
from flatland_server import (
    BatchRole,
    Circle,
    FlatlandError,
    GoneError,
    MessageError,
    ModelBody,
    ModelPlugin,
    Pose,
    Timekeeper,
    UpdateTimer,
    YamlReader,
)

logger = logging.getLogger(__name__)

_LONGEST_WAY = 1.0
"""The distance [m] from which on a pedestrian jumps to its agent, instead of walking there."""


class Pedestrian(ModelPlugin):
    """Moves a body as an agent of another program, or by itself, with the motion of a Crowd.

    Agents are given as nav_msgs/Odometry, or as pedsim_msgs/AgentStates where that package is.
    Between two updates Box2D moves the bodies at their velocities, and resolves collisions.
    """

    def on_initialize(self, config: YamlReader) -> None:
        key = given_name(config, "body", "base_body")
        self._body = self.get_body(config, key, self.model.base.name)
        _check_moves(config, key, self._body)
        legs = [self._get_part(config, f"{name}_body", name) for name, _ in LEGS]
        self._legs = [leg for leg in legs if leg is not None]
        if len(self._legs) == 1:
            key = f"{LEGS[legs.index(None)][0]}_body"
            config.problem(f'the required key "{key}" is missing')
        self._circle = self._get_part(config, "safety_dist_body", "")
        keys = self._keys = PedestrianKeys.read(config, self.model, self._legs, self._circle)
        config.finish()

        self._shape(config)
        self._stand()
        reach = reach_of([keys.person.build], keys.walk.force)
        self._around = Surroundings(self.model.entities, keys.walk.layer_bits, reach)
        self._person = Person(keys.person, self.model, self._body, self._legs, self._circle)
        self._motion = self._make_motion(1)
        self._motion.begin(0, self.rng, None)
        self._lifted = 0.0
        self._is_ignoring = False
        self._agent: Optional[Agent] = None
        self.update_timer = UpdateTimer(keys.walk.update_rate)
        self.node.subscribe(keys.odom_sub, "nav_msgs/Odometry", self._on_odometry)
        if keys.agent_topic is not None:
            try:
                self.node.subscribe(
                    keys.agent_topic, "pedsim_msgs/AgentStates", self._on_agent_states
                )
            except MessageError as error:
                logger.warning("%s: agent_topic has no effect: %s", self.node.owner, error)

    def _get_part(self, config: YamlReader, key: str, default: str) -> Optional[ModelBody]:
        """The body named by a key, or the one of the default name, if there is one."""
        is_there = default in self.model.bodies
        body = self.get_body(config, key, default if is_there else self._body.name)
        if body is self._body:
            return None
        _check_moves(config, key, body)
        return body

    def _shape(self, config: YamlReader) -> None:
        """Sets sizes, and hides from lasers all but the legs."""
        keys = self._keys
        sizes = [(f"{name}_body", leg, keys.leg_radius) for leg, (name, _) in zip(self._legs, LEGS)]
        if self._circle is not None:
            sizes.append(("safety_dist_body", self._circle, keys.safety_dist))
        for key, body, radius in sizes:
            circle, footprints = Circle((0.0, 0.0), radius), body.config.footprints
            if len(footprints) != 1:
                found = f"found {len(footprints)}"
                raise config.error(f'expected one footprint of "{body.name}", {found}', key)
            if footprints[0].shape != circle:
                try:
                    self.model.set_footprint(body.name, 0, circle)
                except FlatlandError as error:
                    raise config.error(str(error), key) from None
        for hidden in (self._body if self._legs else None, self._circle):
            for fixture in hidden.physics_body.fixtures if hidden else ():
                fixture.visible = False

    def _stand(self) -> None:
        """Puts the other bodies in their places at the body, with the feet abreast."""
        offset = leg_offset(self._keys.person.build)
        for leg, (_, side) in zip(self._legs, LEGS):
            leg.physics_body.pose = self._body.pose.compose(Pose(0.0, side * offset))
        if self._circle is not None:
            self._circle.physics_body.pose = self._body.pose

    # Motion

    def before_physics_step(self, timekeeper: Timekeeper) -> None:
        """Sets the velocities until the next update."""
        step_size = timekeeper.step_size
        if self._agent is None:
            self._motion.see(self._find_others())
            self._motion.update_alone(step_size)
        else:
            self._motion.see(())
            velocity = self._towards(self._agent, self._motion.time_of(step_size))
            self._motion.update_alone(step_size, velocity)
        self._lift(self._phase())

    def _towards(self, agent: Agent, dt: float) -> Sequence[float]:
        """The velocity [m/s] that leads to an agent in `dt` seconds."""
        if math.dist(agent.point, self._body.pose[:2]) > _LONGEST_WAY:
            self._body.physics_body.pose = (*agent.point, self._body.pose.yaw)
            self._stand()
        agent.advance(dt)
        here = self._body.pose
        return (agent.x - here.x) / dt, (agent.y - here.y) / dt

    def _phase(self) -> float:
        """The height of the lifted foot, 0 to 1; negative for the right one."""
        walks = math.hypot(*self._body.physics_body.velocity[:2]) > LEAST_SPEED
        return math.sin(math.tau * self._motion.progress.strides[0, 0]) if walks else 0.0

    def _lift(self, phase: float) -> None:
        """Makes a leg that swings as thin as it is above a lifted foot."""
        self._lifted = phase
        radius, thin = self._keys.leg_radius, self._keys.swing_radius
        if thin != radius:
            for leg, (_, side) in zip(self._legs, LEGS):
                seen = radius + (thin - radius) * max(0.0, side * phase)
                leg.physics_body.fixture(0).seen_radius = seen

    @property
    def batch_role(self) -> Optional[BatchRole]:
        """The motion by itself; None if the legs change their sizes, which a batch cannot do."""
        if self._keys.swing_radius != self._keys.leg_radius:
            return None
        return BatchRole(make_motion=self._make_motion)

    def _make_motion(self, count: int) -> "_Motion":
        around, others = self._around, self._find_others()
        walk, people = self._keys.walk, [self._person]
        return _Motion(walk, around.walls, around.see_walls, people, others, count)

    def _find_others(self) -> List[Outline]:
        return self._around.bodies.find(but={self.model})

    # Agents

    def _on_odometry(self, message: Any) -> None:
        self._follow(from_odometry(message))

    def _on_agent_states(self, message: Any) -> None:
        for agent in from_agent_states(message, self._keys.agent_id):
            self._follow(agent)

    def _follow(self, agent: Agent) -> None:
        """Follows an agent; warns of the first in a series of invalid ones."""
        if agent.is_valid:
            self._agent = agent
        elif not self._is_ignoring:
            expected = f"expected an agent with numbers below {FARTHEST:g}"
            logger.warning("%s: %s, found %s", self.node.owner, expected, agent)
        self._is_ignoring = not agent.is_valid

    # State

    def get_state(self) -> Dict[str, Any]:
        """The goal, the phases of the gait, and what is followed."""
        agent = None if self._agent is None else astuple(self._agent)
        return {**self._motion.get_state(0), "lifted": self._lifted, "agent": agent}

    def set_state(self, state: Dict[str, Any]) -> None:
        self._motion.set_state(0, {**state, "agent": None})
        self._lift(state["lifted"])
        self._agent = None if state["agent"] is None else Agent(*state["agent"])

    def on_shutdown(self) -> None:
        """Stops the bodies, if they outlive the plugin."""
        with contextlib.suppress(GoneError):
            for body in self._motion.moved:
                body.velocity = (0.0, 0.0, 0.0)


class _Motion(CrowdMotion):
    """The motion by itself."""

    def get_state(self, environment: int) -> Any:
        goals, strides = self.progress
        progress = {"goal": int(goals[environment, 0]), "stride": float(strides[environment, 0])}
        return {**progress, "lifted": 0.0, "agent": None}

    def set_state(self, environment: int, state: Any) -> None:
        if state["agent"] is not None:
            raise ValueError("expected a pedestrian that walks by itself, found one with an agent")
        goals, strides = self.progress
        goals[environment, 0], strides[environment, 0] = state["goal"], state["stride"]


def _check_moves(config: YamlReader, key: str, body: ModelBody) -> None:
    """Notes a problem if the body named by a key is static."""
    if body.config.type == "static":
        config.problem(f'expected a body that moves, found "{body.name}", a static one', key)
