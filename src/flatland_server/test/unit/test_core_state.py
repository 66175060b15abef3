"""The state of the physical world: saved, restored in another world, and refused if damaged."""

import math
import random
import subprocess
import sys
from typing import Any, List, Tuple

import pytest

from flatland_server import _core

ROOM = [[-2, -2, 2, -2], [2, -2, 2, 2], [2, 2, -2, 2], [-2, 2, -2, -2], [-1.0, 0.5, 0.4, 0.9]]
SQUARE = [(-0.15, -0.1), (0.15, -0.1), (0.15, 0.1), (-0.15, 0.1)]


class Parts:
    """A room with boxes and discs, a trailer, two robots, a door and a sensor; always the same."""

    def __init__(self) -> None:
        self.world = world = _core.World()
        self.events: List[Tuple[Any, ...]] = []
        draw = random.Random(7)
        self.bodies = [world.add_layer(ROOM, 1)]
        for index in range(24):
            pose = (draw.uniform(-1.8, 1.8), draw.uniform(-1.8, 1.8), draw.uniform(-3, 3))
            body = world.add_body("dynamic", pose, 0.3, 0.3)
            material = {"density": 2.0, "friction": 0.4, "restitution": 0.3, "layers": 1}
            if index % 2:
                body.add_polygon(SQUARE, **material)
            else:
                body.add_circle((0.05, 0.0), 0.12, sensor=index == 4, **material)
            self.bodies.append(body)
        _, a, b, c, *_ = self.bodies
        self.joints = [
            a.add_revolute(b, (0.2, 0.0), (-0.2, 0.0), limits=(-0.5, 0.5)),
            b.add_weld(c, (0.2, 0.0), (-0.2, 0.0), frequency=4.0, damping=0.5),
        ]
        self.drive = a.add_drive((1.0, 1.0, 0.0), (2.0, 2.0, 0.0))
        base, wheel = self.bodies[-1], self.bodies[-2]
        wheel.pose = base.pose
        self.joints.append(base.add_revolute(wheel, (0.0, 0.0), (0.0, 0.0)))
        joint = self.joints[-1]
        self.tricycle = base.add_tricycle(joint, (-0.5, 0.0), 1.0, (1.0, 1.0, 0.0), (2.0, 2.0, 0.0))
        slip = (2.0, 0.05, 0.15, 0.05, 1.0, 4.0, 5.0)
        self.car = self.bodies[8].add_ackermann(0.3, 0.5, jerk_limit=9.0, single_track=slip)
        self.tween = self.bodies[9].add_tween((1.0, 0.5, 1.0), 0.7, "trigger", "cubicInOut")
        for body in self.bodies:
            body.listen_to_contacts(15)
        world.set_contact_listener(self._record)

    def _record(self, event: int, a: int, b: int, contact: Any, *details: Any) -> None:
        impulses = details[0].normal_impulses if details else ()
        self.events.append((event, a, b, contact.points, contact.friction, *impulses))
        if event == _core.PRE_SOLVE and (a + b) % 5 == 0:
            contact.friction = 1.5

    def stir(self, seed: int) -> None:
        """Pushes and commands, some of which take effect in the next step."""
        draw = random.Random(seed)
        for body in self.bodies[1:]:
            body.apply_linear_impulse((draw.uniform(-0.1, 0.1), draw.uniform(-0.1, 0.1)))
            body.apply_force((draw.uniform(-1, 1), 0.3), body.world_point((0.1, 0.1)))
        self.drive.command(draw.uniform(-1, 1), 0.2, draw.uniform(-2, 2))
        self.tricycle.command(draw.uniform(-1, 1), draw.uniform(-1, 1))
        self.car.command_within(draw.uniform(-1, 3), draw.uniform(-1, 1), 2.0, 3.0, 0.0)
        self.tween.trigger(draw.random() < 0.7)
        for joint in (self.joints[0], self.joints[-1]):
            joint.motor = (draw.uniform(-3, 3), draw.random()) if draw.random() < 0.8 else None
            joint.limits = (
                (draw.uniform(-9, 0), draw.uniform(0, 9)) if draw.random() < 0.8 else None
            )
        for body in self.bodies[10:20]:
            center = draw.uniform(-0.1, 0.1), draw.uniform(-0.1, 0.1)
            body.set_mass(draw.uniform(0.05, 0.3), inertia=draw.random(), local_center=center)
        self.bodies[10 + draw.randrange(10)].reset_mass()

    def run(self, seed: int, steps: int = 300) -> "Parts":
        """Makes steps, with pushes and commands in between."""
        for step in range(steps):
            if step % 60 == 0:
                self.stir(seed + step)
            self.world.step(0.004 if step < 150 else 0.005)
        return self

    @property
    def motion(self) -> List[Any]:
        """The visible state of bodies and mechanisms, and the contacts since the last call."""
        events, self.events = self.events, []
        bodies = [(*body.pose, *body.velocity, body.awake) for body in self.bodies]
        more = [joint.angle for joint in self.joints]
        more += [(joint.limits, joint.motor) for joint in (self.joints[0], self.joints[-1])]
        more += [(body.mass, body.inertia, body.local_center) for body in self.bodies]
        more += [*self.drive.velocity, self.tricycle.speed, self.tricycle.steer_angle]
        more += [self.car.speed, self.car.steer_angle, self.car.slip_angle]
        return [bodies, more, self.tween.progress, events]


@pytest.mark.parametrize("steps", [0, 1, 100, 250, 700])
def test_a_restored_world_continues_bit_for_bit(steps):
    first = Parts().run(1, steps)
    first.stir(2)  # forces that are still to act
    before = first.motion
    saved = first.world.save_state()

    second = Parts().run(3, 40)
    second.world.restore_state(saved)
    second.events.clear()

    assert first.motion[:3] == before[:3] == second.motion[:3]
    assert second.world.save_state() == saved
    for seed in range(3):
        assert second.run(seed).motion == first.run(seed).motion


def test_saving_changes_nothing():
    saved, untouched = Parts().run(1, 200), Parts().run(1, 200)
    for seed in range(3):
        saved.world.save_state()
        assert saved.run(seed).motion == untouched.run(seed).motion


def test_saving_does_not_change_when_a_body_falls_asleep():
    def sleeps_after(saves: bool) -> int:
        world = _core.World()
        body = world.add_body("dynamic", (0.0, 0.0, 0.0))
        body.add_circle((0.0, 0.0), 0.1, density=1.0)
        steps = 0
        while body.awake and steps < 1000:
            world.step(0.01)
            if saves:
                world.save_state()
            steps += 1
        return steps

    assert sleeps_after(saves=True) == sleeps_after(saves=False) < 100


def test_restoring_keeps_handles_valid_and_contacts_equal():
    parts = Parts()
    kept = set()
    parts.world.set_contact_listener(lambda event, a, b, contact, *_: kept.add(contact))
    parts.run(1, 200)
    ended = set()
    parts.world.set_contact_listener(
        lambda event, a, b, contact, *_: event == _core.END_CONTACT and ended.add(contact)
    )

    parts.world.save_state()
    for body in parts.bodies[1:]:
        assert body.alive
        assert math.isfinite(body.mass)
        body.remove()

    assert ended
    assert ended <= kept


@pytest.mark.parametrize(
    ("change", "difference"),
    [
        (lambda parts: parts.world.add_body("static", (0, 0, 0)), "bodies: expected 26, found 25"),
        (
            lambda parts: parts.bodies[3].add_circle((0.0, 0.0), 0.1, density=1.0),
            "footprints or walls of a body: expected 2, found 1",
        ),
        (lambda parts: parts.bodies[3].add_drive(), "the number of drives: expected 2, found 1"),
    ],
)
def test_a_state_of_another_world_is_refused_with_the_difference(change, difference):
    saved, other = Parts().world.save_state(), Parts()
    change(other)

    with pytest.raises(ValueError, match=f"another world: .*{difference}"):
        other.world.restore_state(saved)


PROGRAM = """
import sys
from flatland_server import _core
world = _core.World()
bodies = [world.add_body("dynamic", (0.29 * i, 0.29 * i, 0.0), 0.0, 0.0) for i in range(3)]
for body in bodies:
    body.add_circle((0.0, 0.0), 0.2, density=1.0)
world.step(0.01)
for body in bodies[:2]:
    body.remove()
sys.stdout.buffer.write(world.save_state())
"""


def test_a_state_has_nothing_of_the_memory_of_its_process():
    """Else a number in it may be one that no state may have."""
    states = {
        subprocess.run([sys.executable, "-c", PROGRAM], check=True, stdout=subprocess.PIPE).stdout
        for _ in range(3)
    }

    assert len(states) == 1
