# pyright: strict, reportUnknownMemberType=false, reportUninitializedInstanceVariable=false
"""A user's plugins, for scripts/check: type checkers find the types that are asserted here."""

from typing import Any

import numpy as np
from typing_extensions import assert_type

from flatland_plugins.diff_drive import DiffDrive
from flatland_server import (
    Body,
    Canvas,
    Contact,
    ContactImpulse,
    ContactSides,
    Fixture,
    FloatArray,
    Manifold,
    Model,
    ModelBody,
    ModelPlugin,
    Node,
    Pose,
    Publisher,
    Timekeeper,
    UpdateTimer,
    World,
    WorldPlugin,
    YamlReader,
)


class Beacon(ModelPlugin):
    """A sensor."""

    def on_initialize(self, config: YamlReader) -> None:
        assert_type(self.node, Node)
        assert_type(self.rng, np.random.Generator)
        assert_type(self.model, Model)
        assert_type(self.name, str)
        assert_type(self.get_body(config), ModelBody)
        assert_type(config.get_float("range", 5.0), float)
        assert_type(config.get_pose("origin", Pose()), Pose)
        assert_type(config.get_string("frame"), str)
        self._body = self.get_body(config).physics_body
        assert_type(self._body, Body)
        self.update_timer = UpdateTimer(config.get_rate("update_rate", 10.0))
        self._publisher = self.node.advertise("beacon", "std_msgs/Float64")
        assert_type(self._publisher, Publisher)
        self.node.subscribe("/lit", "std_msgs/Bool", self._switch)
        self._is_lit = True

    def _switch(self, message: Any) -> None:
        self._is_lit = bool(message.data)

    def before_physics_step(self, timekeeper: Timekeeper) -> None:
        assert_type(timekeeper.seconds, float)
        assert_type(self._body.pose, tuple[float, float, float])
        self._body.velocity = (0.0, 0.0, float(self.rng.normal()))

    def begin_contact(self, contact: Contact) -> None:
        sides = self.filter_contact(contact)
        assert_type(sides, ContactSides | None)
        if sides is not None:
            assert_type(sides.this_fixture, Fixture)
            assert_type(sides.entity.name, str)

    def pre_solve(self, contact: Contact, old_manifold: Manifold) -> None:
        contact.set_enabled(False)

    def post_solve(self, contact: Contact, impulse: ContactImpulse) -> None:
        assert_type(impulse.normal_impulses, list[float])

    def read(self, timekeeper: Timekeeper) -> FloatArray:
        return np.array(self._body.pose)

    def draw(self, canvas: Canvas, timekeeper: Timekeeper) -> None:
        canvas.dots(np.zeros((1, 2)), (1.0, 0.0, 0.0, 1.0))

    def get_state(self) -> dict[str, bool]:
        return {"lit": self._is_lit}

    def set_state(self, state: dict[str, bool]) -> None:
        self._is_lit = state["lit"]


class Referee(WorldPlugin):
    """A plugin of the world."""

    def on_initialize(self, config: YamlReader) -> None:
        assert_type(self.world, World)
        self._goal = config.get_string("goal")

    def after_physics_step(self, timekeeper: Timekeeper) -> None:
        ball = self.world.models.get(self._goal)
        assert_type(ball, Model | None)
        if ball is not None and ball.pose.x > 1.0:
            self.world.move_model("ball", (0.0, 0.0, 0.0))


class Faster(DiffDrive):
    """A drive that goes twice as fast as it is told to."""

    def command(self, speed: float, yaw_rate: float) -> None:
        super().command(2.0 * speed, yaw_rate)
