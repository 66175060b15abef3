"""Bumper: what the bodies of a model collide with, and how hard."""

import math
from dataclasses import dataclass, field
from itertools import zip_longest
from typing import Any, Dict, List, NamedTuple, Tuple

from flatland_server import (
    BatchRole,
    Contact,
    ContactImpulse,
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


@dataclass
class Touch:
    """A contact from the model's side: the normal points from the model to the other entity."""

    sides: ContactSides
    has_sensor: bool = False
    """True if one of the two fixtures is a sensor, which the other passes through."""
    points: List[Point] = field(default_factory=list)
    normal: Point = (0.0, 0.0)
    impulses: List[float] = field(default_factory=list)
    """At each point, of this step [N s]; none if the solver did not see the contact."""

    def is_collision(self) -> bool:
        """True if the contact is to be reported: unless it is solid and a plugin has disabled it.

        The solver sees all solid contacts but those of sleeping bodies.
        """
        if self.has_sensor:
            return True
        bodies = (self.sides.this_fixture.body, self.sides.other_fixture.body)
        rests = not any(body.type == "dynamic" and body.awake for body in bodies)
        return bool(self.impulses) or rests


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
        self._touches: Dict[Tuple[Fixture, Fixture], Touch] = {}
        self._over: List[Touch] = []
        self._last: List[Tuple[Touch, List[float], float]] = []  # impulses, and the step's length
        self._restored: List[Bump] = []  # those of `_last` when the state was saved

    def begin_contact(self, contact: Contact) -> None:
        """Records a contact with a sensor; the solver does not see those."""
        if not (contact.fixture_a.sensor or contact.fixture_b.sensor):
            return
        sides = self.filter_contact(contact)
        if sides is not None and not self._is_excluded(sides):
            self._touches[_fixtures(contact)] = Touch(sides, has_sensor=True)

    def post_solve(self, contact: Contact, impulse: ContactImpulse) -> None:
        """Records a contact's points and impulses; a step may solve it more than once."""
        key = _fixtures(contact)
        touch = self._touches.get(key)
        if touch is None:
            sides = self.filter_contact(contact)
            if sides is None or self._is_excluded(sides):
                return
            touch = self._touches[key] = Touch(sides)
        flip = 1.0 if touch.sides.this_fixture == contact.fixture_a else -1.0
        x, y = contact.normal
        touch.points, touch.normal = contact.points, (flip * x, flip * y)
        summed = zip_longest(touch.impulses, impulse.normal_impulses, fillvalue=0.0)
        touch.impulses = [a + b for a, b in summed][: len(touch.points)]

    def end_contact(self, contact: Contact) -> None:
        """Forgets a contact; one that was solved in this step is still to be reported."""
        touch = self._touches.pop(_fixtures(contact), None)
        if touch is not None and touch.impulses:
            self._over.append(touch)

    def after_physics_step(self, timekeeper: Timekeeper) -> None:
        """Publishes the collisions at the end of the step."""
        # Contacts that were disabled are no collisions until the solver sees them again.
        self._touches = {key: touch for key, touch in self._touches.items() if touch.is_collision()}
        touches = [*self._touches.values(), *self._over]
        step_size = timekeeper.step_size
        self._last = [(touch, touch.impulses, step_size) for touch in touches]
        self._restored = []
        is_due = self._timer.check_update(timekeeper)
        if (is_due or (self._publish_all and touches)) and self._publisher.has_subscribers:
            self.publish_now(timekeeper)
        self._over.clear()
        for touch in self._touches.values():
            touch.impulses = []

    def publish_now(self, timekeeper: Timekeeper) -> None:
        collisions = Collisions(header=header(timekeeper.nanoseconds, self._frame))
        collisions.collisions = [self._collision(bump) for bump in self.read(timekeeper)]
        self._publisher.publish(collisions)

    def read(self, timekeeper: Timekeeper) -> List[Bump]:
        """The collisions of the last step; without those of bodies that have been deleted since."""
        return self._bumps()

    def get_state(self) -> Dict[str, Any]:
        """The present touches, without impulses, and the value of `read`."""
        describe = self.model.entities.describe
        touches = [
            {
                "fixtures": [describe(a), describe(b)],
                "is_a": touch.sides.this_fixture == a,
                "has_sensor": touch.has_sensor,
                "points": touch.points,
                "normal": touch.normal,
            }
            for (a, b), touch in self._touches.items()
        ]
        bumps = [list(bump) for bump in self._bumps()]
        return {"touches": touches, "timer": self._timer.get_state(), "bumps": bumps}

    def set_state(self, state: Dict[str, Any]) -> None:
        entities = self.model.entities
        self._timer.set_state(state["timer"])
        self._touches.clear()
        for each in state["touches"]:
            a, b = (entities.fixture(description) for description in each["fixtures"])
            this, other = (a, b) if each["is_a"] else (b, a)
            sides = ContactSides(entities.owner(other.body.id), this, other)
            points = [(x, y) for x, y in each["points"]]
            touch = Touch(sides, each["has_sensor"], points, tuple(each["normal"]))
            self._touches[a, b] = touch
        self._last = []
        self._restored = [
            Bump(body, model, other, tuple(map(tuple, points)), tuple(normal), tuple(forces))
            for body, model, other, points, normal, forces in state["bumps"]
        ]

    def _is_excluded(self, sides: ContactSides) -> bool:
        """True if an excluded body takes part; between bodies of the model, on either side."""
        fixtures = [sides.this_fixture]
        if sides.entity is self.model:
            fixtures.append(sides.other_fixture)
        return any(self.model.body_name(fixture) in self._excluded for fixture in fixtures)

    def _bumps(self) -> List[Bump]:
        alive = [each for each in self._last if each[0].sides.other_fixture.body.alive]
        return [*self._restored, *(self._bump(*each) for each in alive)]

    def _bump(self, touch: Touch, impulses: List[float], step_size: float) -> Bump:
        entity, this_fixture, other_fixture = touch.sides
        return Bump(
            self.model.body_name(this_fixture),
            entity.name,
            entity.body_name(other_fixture),
            tuple(touch.points),
            touch.normal,
            tuple(each / step_size for each in impulses or [0.0] * len(touch.points)),
        )

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


def _fixtures(contact: Contact) -> Tuple[Fixture, Fixture]:
    """The fixtures of a contact, which identify it even after a state was loaded."""
    return contact.fixture_a, contact.fixture_b
