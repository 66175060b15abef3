"""Actions of a plugin on its body in contact hooks: allowed ones and refused ones."""

import numpy as np
import pytest
from contacts.room import BOUNCING, DT, INERTIA, MASS, actions, called_hooks, calls

from flatland_server.geometry import Pose

CONTACT_HOOKS = ("begin_contact", "pre_solve", "post_solve", "end_contact")


def test_a_velocity_set_in_begin_contact_replaces_the_response(room):
    def turn_back(plugin, _):
        plugin.model.base.physics_body.velocity = (-3.0, 0.0, 0.0)

    actions["begin_contact"] = turn_back
    ball = room.put("ball", (0.8, 0.0, 0.0), (2.0, 0.0, 0.0), "Listener")

    room.run(0.2)

    assert ball.base.physics_body.velocity == pytest.approx((-3.0, 0.0, 0.0))
    assert called_hooks().count("begin_contact") == called_hooks().count("end_contact") == 1


PUSHES = {
    "impulse": (lambda body: body.apply_linear_impulse((0.0, 0.5)), (0.5 / MASS, 0.0)),
    "angular impulse": (lambda body: body.apply_angular_impulse(0.001), (0.0, 0.001 / INERTIA)),
    "force": (lambda body: body.apply_force((0.0, 0.5 / DT)), (0.5 / MASS, 0.0)),
    "torque": (lambda body: body.apply_torque(0.001 / DT), (0.0, 0.001 / INERTIA)),
}


@pytest.mark.parametrize(
    ("hook", "kind"),
    [
        (hook, kind)
        for hook in CONTACT_HOOKS
        for kind in PUSHES
        if hook != "post_solve" or "impulse" in kind  # too late for forces
    ],
)
def test_a_body_can_be_pushed_in_contact_hooks(room, hook, kind):
    """A disc that is pushed once while it bounces off the wall: its velocity along it, and turn."""
    push, expected = PUSHES[kind]

    def push_once(plugin, *_):
        push(plugin.model.base.physics_body)
        del actions[hook]

    actions[hook] = push_once
    ball = room.put("ball", (0.8, 0.0, 0.0), (2.0, 0.0, 0.0), "Listener", BOUNCING)

    room.run(0.2)

    assert (room.world.plugin_failures, actions) == ([], {})
    velocity = ball.base.physics_body.velocity[1:]
    assert velocity == pytest.approx(expected, rel=1e-4, abs=1e-5)


@pytest.mark.parametrize("hook", CONTACT_HOOKS)
@pytest.mark.parametrize(
    "action",
    [
        lambda m, b: setattr(b, "pose", (0.0, 0.0, 0.0)),
        lambda m, b: m.move(Pose()),
        lambda m, b: b.remove(),
        lambda m, b: m.physics.add_body("dynamic", (0, 0, 0)),
        lambda m, b: m.physics.add_layer(np.eye(1, 4), 1),
        lambda m, b: b.add_circle((0, 0), 1.0, density=1.0),
        lambda m, b: b.add_drive(),
        lambda m, b: b.add_tween((1, 0, 0), 1.0),
        lambda m, b: m.physics.set_contact_listener(None),
        lambda m, b: m.physics.step(DT),
    ],
)
def test_an_impossible_change_in_a_hook_disables_only_its_plugin(room, hook, action, caplog):
    def try_it(plugin, *_):
        if plugin.label == "bad/p0":
            action(plugin.model, plugin.model.base.physics_body)

    actions[hook] = try_it
    for name, y in (("bad", 0.0), ("good", 2.0)):
        room.put(name, (0.8, y, 0.0), (2.0, 0.0, 0.0), "Listener", BOUNCING)
    room.run(0.2)

    [failure] = room.world.plugin_failures
    assert (failure.owner, failure.name) == ("bad", "p0")
    assert failure.reason.startswith(f"{hook}: RuntimeError: ")
    assert failure.reason.endswith("wait for the end of the step")
    assert called_hooks("bad/p0")[-1] == hook
    assert called_hooks("good/p0")[-1] == "after_physics_step"
    bad = room.world.get_model("bad").base.physics_body
    assert bad.velocity == pytest.approx((-2.0, 0.0, 0.0))  # unchanged
    assert room.world.physics.body_count == 3


@pytest.mark.parametrize("hook", CONTACT_HOOKS)
def test_an_interrupt_in_a_hook_leaves_a_usable_world(room, hook):
    def interrupt(*_):
        del actions[hook]
        raise KeyboardInterrupt

    actions[hook] = interrupt
    ball = room.put("ball", (0.8, 0.0, 0.0), (2.0, 0.0, 0.0), "Listener", BOUNCING)

    with pytest.raises(KeyboardInterrupt):
        room.run(0.2)

    assert room.world.plugin_failures == []
    ball.base.physics_body.velocity = (2.0, 0.0, 0.0)
    room.world.move_model("ball", Pose(0.5, 0.0, 0.0))
    room.run()  # ends the contact, if there is one
    calls.clear()
    ball.base.physics_body.velocity = (2.0, 0.0, 0.0)
    room.run(0.3)
    contact_hooks = [hook for hook in dict.fromkeys(called_hooks()) if "step" not in hook]
    assert contact_hooks == list(CONTACT_HOOKS)
    room.world.delete_model("ball")
    assert room.world.physics.body_count == 1
