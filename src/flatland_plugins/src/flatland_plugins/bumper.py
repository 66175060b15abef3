"""Bumper: what the bodies of a model collide with, and how hard."""

import math
from dataclasses import dataclass, field
from itertools import zip_longest
from typing import Dict, List, Tuple

from flatland_msgs.msg import Collision, Collisions, Vector2

from flatland_plugins.messages import header
from flatland_server import (
    Contact,
    ContactImpulse,
    ContactSides,
    ModelPlugin,
    Timekeeper,
    UpdateTimer,
    YamlReader,
)

Point = Tuple[float, float]


@dataclass
class Touch:
    """A contact as the model has it: its normal points from the model to the other entity."""

    sides: ContactSides
    points: List[Point] = field(default_factory=list)
    normal: Point = (0.0, 0.0)
    impulses: List[float] = field(default_factory=list)
    """At each point, of this step [N s]; none if the solver did not look at it."""

    def is_collision(self) -> bool:
        """Whether the two hold each other up: not if some plugin lets them pass each other.

        The solver looks at all contacts but those of bodies that have come to rest.
        """
        bodies = (self.sides.this_fixture.body, self.sides.other_fixture.body)
        rests = not any(body.type == "dynamic" and body.awake for body in bodies)
        return bool(self.impulses) or rests


class Bumper(ModelPlugin):
    """Publishes flatland_msgs/Collisions; sensors do not collide.

    A force is the impulse of a step by its length: a ball park figure of how strong an impact is.
    """

    def on_initialize(self, config: YamlReader) -> None:
        """Reads the documented keys and opens the topic."""
        self._frame = config.get_string("world_frame_id", "map")
        topic = config.get_string("topic", "collisions")
        update_rate = config.get_rate("update_rate", math.inf)
        self._publish_all = config.get_bool("publish_all_collisions", True)
        self._excluded = self.get_body_names(config, "exclude")
        config.finish()
        self._timer = UpdateTimer(update_rate)
        self._publisher = self.node.advertise(topic, Collisions)
        self._touches: Dict[Contact, Touch] = {}
        self._over: List[Touch] = []

    def post_solve(self, contact: Contact, impulse: ContactImpulse) -> None:
        """Notes where a contact is, and its impulses; a step may solve it more than once."""
        touch = self._touches.get(contact)
        if touch is None:
            sides = self.filter_contact(contact)
            if sides is None or self._is_excluded(sides):
                return
            touch = self._touches[contact] = Touch(sides)
        flip = 1.0 if touch.sides.this_fixture == contact.fixture_a else -1.0
        x, y = contact.normal
        touch.points, touch.normal = contact.points, (flip * x, flip * y)
        summed = zip_longest(touch.impulses, impulse.normal_impulses, fillvalue=0.0)
        touch.impulses = [a + b for a, b in summed][: len(touch.points)]

    def end_contact(self, contact: Contact) -> None:
        """Forgets a contact; one that this step has solved is still to be told of."""
        touch = self._touches.pop(contact, None)
        if touch is not None and touch.impulses:
            self._over.append(touch)

    def after_physics_step(self, timekeeper: Timekeeper) -> None:
        """Publishes the collisions at the end of the step."""
        # Those that have been switched off are no collisions until the solver sees them again.
        self._touches = {key: touch for key, touch in self._touches.items() if touch.is_collision()}
        touches = [*self._touches.values(), *self._over]
        is_due = self._timer.check_update(timekeeper)
        if (is_due or (self._publish_all and touches)) and self._publisher.has_subscribers:
            collisions = Collisions(header=header(timekeeper.nanoseconds, self._frame))
            step_size = timekeeper.step_size
            collisions.collisions = [self._collision(touch, step_size) for touch in touches]
            self._publisher.publish(collisions)
        self._over.clear()
        for touch in self._touches.values():
            touch.impulses = []

    def _is_excluded(self, sides: ContactSides) -> bool:
        """Whether a body to ignore is in it; of bodies of one model, either side may be it."""
        fixtures = [sides.this_fixture]
        if sides.entity is self.model:
            fixtures.append(sides.other_fixture)
        return any(self.model.body_name(fixture) in self._excluded for fixture in fixtures)

    def _collision(self, touch: Touch, step_size: float) -> Collision:
        entity, this_fixture, other_fixture = touch.sides
        return Collision(
            entity_A=self.model.name,
            body_A=self.model.body_name(this_fixture),
            entity_B=entity.name,
            body_B=entity.body_name(other_fixture),
            magnitude_forces=[
                impulse / step_size for impulse in touch.impulses or [0.0] * len(touch.points)
            ],
            contact_positions=[Vector2(x, y) for x, y in touch.points],
            contact_normals=[Vector2(*touch.normal) for _ in touch.points],
        )
