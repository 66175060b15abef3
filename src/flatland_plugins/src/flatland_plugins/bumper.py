"""Bumper: what the bodies of a model collide with, and how hard."""

import math
from typing import Any, Dict, Iterator, List, NamedTuple, Optional, Tuple

from flatland_server import (
    BatchRole,
    ContactSides,
    Fixture,
    ModelPlugin,
    Timekeeper,
    UpdateTimer,
    YamlReader,
    header,
    messages,
)

Collision = messages.get("flatland_msgs/Collision")
Collisions = messages.get("flatland_msgs/Collisions")
Vector2 = messages.get("flatland_msgs/Vector2")

Point = Tuple[float, float]


class Bump(NamedTuple):
    """A collision of a body of the model with another body."""

    body: str
    other_model: str
    """The model, or the layer of walls."""
    other_body: str
    points: Tuple[Point, ...]
    """Up to two points where they touch, in the world [m]; none with a sensor."""
    normal: Point
    """Unit vector from the model to the other, in the world's frame."""
    forces: Tuple[float, ...]
    """At each point [N]."""


class Bumper(ModelPlugin):
    """Publishes flatland_msgs/Collisions.

    A force is the impulse of a step divided by its length: the mean force, which for an impact is a
    rough figure. What touches a sensor, or what a sensor of the model touches, is reported without
    points: Box2D computes none.
    """

    batch_role = BatchRole()

    def on_initialize(self, config: YamlReader) -> None:
        self._frame = self.get_frame_id(config, "world_frame_id", "map")
        topic = config.get_topic("topic", "collisions")
        update_rate = config.get_rate("update_rate", math.inf)
        self._publish_all = config.get_bool("publish_all_collisions", True)
        self._excluded = self.get_body_names(config, "exclude")
        config.finish()
        self._timer = UpdateTimer(update_rate)
        self._publisher = self.node.advertise(topic, "flatland_msgs/Collisions")
        self._bodies = self.model.record_collisions()
        self._restored: List[Bump] = []  # the value of `read` when the state was saved
        self._has_stepped = False  # since the start, or since a state was restored

    def has_work(self) -> bool:
        """True if the topic has a subscriber; and in the first step, from which the rate counts."""
        return not self._has_stepped or self._publisher.has_subscribers

    def after_physics_step(self, timekeeper: Timekeeper) -> None:
        """Publishes the collisions at the end of the step."""
        if self._has_stepped:  # perhaps it was idle until now, while updates were due
            self._timer.check_update_at(timekeeper.nanoseconds - timekeeper.step_nanoseconds)
        else:
            self._has_stepped, self._restored = True, []
            self.update_timer = None  # `has_work` is called again
        is_due = self._timer.check_update(timekeeper)
        if self._publisher.has_subscribers:
            bumps = self._bumps()
            if is_due or (self._publish_all and bumps):
                self._publish(timekeeper, bumps)

    def publish_now(self, timekeeper: Timekeeper) -> None:
        self._publish(timekeeper, self._bumps())

    def read(self, timekeeper: Timekeeper) -> List[Bump]:
        """The collisions of the last step; without those of bodies that have been deleted since."""
        return self._bumps()

    def get_state(self) -> Dict[str, Any]:
        """The present collisions, without impulses, and the value of `read`."""
        describe = self.model.entities.describe
        touches = [
            {
                "number": number,
                "fixtures": [describe(a), describe(b)],
                "has_sensor": has_sensor,
                "points": points,
                "normal": normal,
            }
            for number, a, b, has_sensor, points, normal, _ in self._bodies.present_collisions()
        ]
        bumps = [list(bump) for bump in self._bumps()]
        return {"touches": touches, "timer": self._timer.get_state(), "bumps": bumps}

    def set_state(self, state: Dict[str, Any]) -> None:
        self._timer.set_state(state["timer"])
        self._has_stepped = False
        for each in state["touches"]:
            a, b = (self.model.entities.fixture(each) for each in each["fixtures"])
            points = [(x, y) for x, y in each["points"]]
            x, y = each["normal"]
            self._bodies.restore_collision(each["number"], a, b, each["has_sensor"], points, (x, y))
        self._restored = [
            Bump(body, model, other, tuple(map(tuple, points)), tuple(normal), tuple(forces))
            for body, model, other, points, normal, forces in state["bumps"]
        ]

    def _bumps(self) -> List[Bump]:
        return [*self._restored, *self._last_bumps()]

    def _last_bumps(self) -> Iterator[Bump]:
        for _, a, b, has_sensor, points, (x, y), forces in self._bodies.last_collisions():
            sides = self._sides(a, b)
            if sides is None or self._is_excluded(sides):
                continue
            entity, this_fixture, other_fixture = sides
            flip = 1.0 if this_fixture == a or has_sensor else -1.0
            yield Bump(
                self.model.body_name(this_fixture),
                entity.name,
                entity.body_name(other_fixture),
                tuple(points),
                (flip * x, flip * y),
                tuple(forces),
            )

    def _sides(self, a: Fixture, b: Fixture) -> Optional[ContactSides]:
        """The sides of a collision; None with a body that is gone, or of no model or layer."""
        owner_a, owner_b = (self.model.entities.find(each.body.id) for each in (a, b))
        if owner_a is None or owner_b is None:
            return None
        return ContactSides(owner_b, a, b) if owner_a is self.model else ContactSides(owner_a, b, a)

    def _is_excluded(self, sides: ContactSides) -> bool:
        """True if an excluded body takes part; between bodies of the model, on either side."""
        fixtures = [sides.this_fixture]
        if sides.entity is self.model:
            fixtures.append(sides.other_fixture)
        return any(self.model.body_name(fixture) in self._excluded for fixture in fixtures)

    def _publish(self, timekeeper: Timekeeper, bumps: List[Bump]) -> None:
        collisions = Collisions(header=header(timekeeper.nanoseconds, self._frame))
        collisions.collisions = [self._collision(bump) for bump in bumps]
        self._publisher.publish(collisions)

    def _collision(self, bump: Bump) -> Any:
        return Collision(
            entity_A=self.model.name,
            body_A=bump.body,
            entity_B=bump.other_model,
            body_B=bump.other_body,
            magnitude_forces=list(bump.forces),
            contact_positions=[Vector2(x, y) for x, y in bump.points],
            contact_normals=[Vector2(*bump.normal) for _ in bump.points],
        )
