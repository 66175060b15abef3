"""Pedestrian: a model that walks, on legs if it has some."""

import contextlib
import logging
from typing import Any, Optional, Sequence

from flatland_plugins.agents import FARTHEST, Agent, from_agent_states, from_odometry
from flatland_plugins.other_names import given_name
from flatland_plugins.pedestrian_config import PedestrianKeys
from flatland_plugins.people import LEGS, Person, leg_offset
from flatland_plugins.timed_noise import draw_key
from flatland_server import (
    BatchRole,
    Circle,
    FlatlandError,
    GoneError,
    MessageError,
    Model,
    ModelBody,
    ModelPlugin,
    Pose,
    YamlReader,
)

logger = logging.getLogger(__name__)


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
        self._is_ignoring = False
        self.node.subscribe(keys.odom_sub, "nav_msgs/Odometry", self._on_odometry)
        if keys.agent_topic is not None:
            try:
                self.node.subscribe(
                    keys.agent_topic, "pedsim_msgs/AgentStates", self._on_agent_states
                )
            except MessageError as error:
                logger.warning("%s: agent_topic has no effect: %s", self.node.owner, error)
        # Last, since a crowd outlives a plugin that fails to start.
        self._crowd = self.model.physics.add_crowd(draw_key(self.rng), **keys.walk.settings)
        person = Person(keys.person, self.model, self._body, self._legs, self._circle)
        person.join(self._crowd, (keys.leg_radius, keys.swing_radius))

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

    @property
    def people(self) -> Sequence[Model]:
        """Its model."""
        return [self.model]

    @property
    def batch_role(self) -> Optional[BatchRole]:
        """The motion by itself; None if the legs change their sizes, which a batch cannot do."""
        if self._keys.swing_radius != self._keys.leg_radius:
            return None
        return BatchRole(crowd=self._crowd)

    # Agents

    def _on_odometry(self, message: Any) -> None:
        self._follow(from_odometry(message))

    def _on_agent_states(self, message: Any) -> None:
        for agent in from_agent_states(message, self._keys.agent_id):
            self._follow(agent)

    def _follow(self, agent: Agent) -> None:
        """Follows an agent; warns of the first in a series of invalid ones."""
        if agent.is_valid:
            self._crowd.follow(0, agent.point, agent.velocity)
        elif not self._is_ignoring:
            expected = f"expected an agent with numbers below {FARTHEST:g}"
            logger.warning("%s: %s, found %s", self.node.owner, expected, agent)
        self._is_ignoring = not agent.is_valid

    def get_state(self) -> None:
        """Nothing: the core keeps the goal, the gait, and the agent that is followed."""

    def on_shutdown(self) -> None:
        """Stops the bodies, if they outlive the plugin."""
        self._crowd.remove()
        with contextlib.suppress(GoneError):
            for body in [self._body, *self._legs, *([self._circle] if self._circle else [])]:
                body.physics_body.velocity = (0.0, 0.0, 0.0)


def _check_moves(config: YamlReader, key: str, body: ModelBody) -> None:
    """Notes a problem if the body named by a key is static."""
    if body.config.type == "static":
        config.problem(f'expected a body that moves, found "{body.name}", a static one', key)
