"""Handles of deleted models and bodies: any use of them raises a clear error."""

import sys
import threading
from contextlib import suppress
from typing import Any, Dict, Tuple

import numpy as np
import pytest

from flatland_server import _core
from flatland_server.exceptions import ModelError
from flatland_server.geometry import Pose


def use(handle: Any, name: str, *arguments: Any) -> Any:
    """Reads or calls an attribute of a handle."""
    value = getattr(handle, name)
    return value(*arguments) if callable(value) else value


def named(names: str, *arguments: Any) -> Dict[str, Tuple[Any, ...]]:
    """Attributes with these arguments."""
    return dict.fromkeys(names.split(), arguments)


CALLS = {
    "body": {
        **named("remove halt fixtures overlapping pose velocity local_velocity type mass inertia"),
        **named("center local_center reset_mass awake add_drive"),
        **named("velocity_at apply_force apply_linear_impulse", (0, 0)),
        **named("world_point local_point world_vector local_vector", (0, 0)),
        **named("fixture apply_torque apply_angular_impulse", 0),
        **named("listen_to_contacts add_drift", 1),
        **named("read_motion", np.zeros(3), np.zeros(3)),
        **named("set_mass", 2.0),
        **named("add_tween", (1, 0, 0), 1),
        **named("add_lidar", _core.BeamFan(0, 0.1, 3), (0, 0, 0), 5.0),
    },
    "fixture": {
        **named("density friction restitution sensor collides visible seen_radius layers"),
        **named("test_point", (0, 0)),
        **named("set_circle", (0, 0), 1),
        **named("set_polygon", ((0, 0), (1, 0), (0, 1))),
    },
    "joint": named("angle speed limits motor motor_torque"),
    "drive": {**named("command", 0, 0, 0), **named("target velocity")},
    "tricycle": {**named("command", 0, 0), **named("speed steer_angle")},
    "car": {
        **named("command", 0, 0),
        **named("command_within", 0, 0, 0, 0, 0),
        **named("speed steer_angle slip_angle"),
    },
    "tween": {**named("trigger", True), **named("progress")},
    "drift": named("pose velocity"),
    "lidar": named("expect_scan ranges scan"),
}
"""The attributes of each kind of handle, with arguments for those that are called."""

ELSEWHERE = {
    "body": {
        *("id", "alive"),  # still work after the end
        *("add_circle", "add_polygon", "add_revolute", "add_weld", "add_tricycle", "add_ackermann"),
    },
    "fixture": {"body", "index"},
    "joint": {"alive"},
}
"""The attributes that other tests use."""


def handles_of(world) -> dict:
    """A handle of each kind, for the robot."""
    robot = world.get_model("robot")
    base, wheel = (body.physics_body for body in robot.bodies.values())
    joint = robot.joints[0].physics_joint
    return {
        "body": base,
        "fixture": base.fixtures[0],
        "joint": joint,
        "drive": base.add_drive(),
        "tricycle": base.add_tricycle(joint, (-0.5, 0)),
        "car": base.add_ackermann(0.5, 0.4, wheels=[joint]),
        "tween": wheel.add_tween((1, 0, 0), 1.0),
        "drift": base.add_drift(1),
        "lidar": base.add_lidar(_core.BeamFan(0, 0.1, 3), (0, 0, 0), 5.0),
    }


@pytest.mark.parametrize("kind", CALLS)
def test_the_tables_list_all_attributes_of_the_handles(world, kind):
    public = {name for name in dir(handles_of(world)[kind]) if not name.startswith("_")}

    assert public == {*CALLS[kind], *ELSEWHERE.get(kind, ())}


@pytest.mark.parametrize("is_slot_taken_again", [False, True])
@pytest.mark.parametrize("kind", CALLS)
def test_using_a_handle_of_a_deleted_model_raises(files, world, kind, is_slot_taken_again):
    handle = handles_of(world)[kind]
    for name, arguments in CALLS[kind].items():
        if name != "remove":
            use(handle, name, *arguments)

    world.delete_model("robot")
    if is_slot_taken_again:
        world.spawn_model(files.folder / "robot.yaml", "robot", "", Pose())
        handles_of(world)

    answers = {}
    for name, arguments in CALLS[kind].items():
        try:
            answers[name] = use(handle, name, *arguments)
        except _core.GoneError as error:
            answers[name] = str(error)
    noun = {"fixture": "body", "tricycle": "drive", "car": "drive"}.get(kind, kind)
    assert answers == dict.fromkeys(CALLS[kind], f"this {noun} has been deleted")


@pytest.mark.parametrize(
    ("kind", "name", "value"),
    [
        ("body", "pose", (0, 0, 0)),
        ("body", "velocity", (0, 0, 0)),
        ("fixture", "friction", 0),
        ("fixture", "restitution", 0),
        ("joint", "limits", (-1, 1)),
        ("joint", "motor", (1, 1)),
    ],
)
def test_setting_an_attribute_of_a_deleted_model_raises(world, kind, name, value):
    handle = handles_of(world)[kind]
    setattr(handle, name, value)
    world.delete_model("robot")

    noun = "joint" if kind == "joint" else "body"
    with pytest.raises(_core.GoneError, match=f"this {noun} has been deleted"):
        setattr(handle, name, value)


def test_attaching_anything_to_a_deleted_body_raises(files, world):
    old = handles_of(world)
    world.delete_model("robot")
    robot = world.spawn_model(files.folder / "robot.yaml", "robot", "", Pose())
    gone, there, joint = old["body"], robot.base.physics_body, robot.joints[0].physics_joint
    before = world.physics.joint_count

    for attach in (
        lambda: gone.add_circle((0, 0), 1.0, density=1.0),
        lambda: gone.add_polygon([(0, 0), (1, 0), (0, 1)], density=1.0),
        lambda: gone.add_revolute(there, (0, 0), (0, 0)),
        lambda: there.add_revolute(gone, (0, 0), (0, 0)),
        lambda: gone.add_weld(there, (0, 0), (0, 0)),
        lambda: there.add_weld(gone, (0, 0), (0, 0)),
        lambda: gone.add_tricycle(joint, (-0.5, 0)),
        lambda: there.add_tricycle(old["joint"], (-0.5, 0)),
        lambda: gone.add_ackermann(0.5, 0.4),
        lambda: there.add_ackermann(0.5, 0.4, wheels=[old["joint"]]),
    ):
        with pytest.raises(_core.GoneError, match="has been deleted"):
            attach()

    assert world.physics.joint_count == before


def test_handles_of_a_deleted_body_can_still_be_compared(files, world):
    old = handles_of(world)
    body, fixture, same = old["body"], old["fixture"], world.get_model("robot").base.physics_body
    world.delete_model("robot")
    robot = world.spawn_model(files.folder / "robot.yaml", "robot", "", Pose())
    new = robot.base.physics_body

    assert not body.alive
    assert (body == same, hash(body) == hash(same), fixture.body == body) == (True, True, True)
    assert body not in {new, *robot.physics_bodies}
    assert fixture not in set(new.fixtures)
    assert body.id != new.id


@pytest.mark.parametrize(
    "ask",
    [
        lambda model, _: model.base,
        lambda model, _: model.pose,
        lambda model, _: model.move(Pose()),
        lambda model, _: model.get_body("base"),
        lambda model, _: model.get_joint("steering"),
        lambda model, fixture: model.body_name(fixture),
    ],
    ids=["base", "pose", "move", "get_body", "get_joint", "body_name"],
)
def test_using_a_deleted_model_raises(world, ask):
    robot = world.get_model("robot")
    fixture = robot.base.physics_body.fixtures[0]
    ask(robot, fixture)

    world.delete_model("robot")

    with pytest.raises(ModelError) as caught:
        ask(robot, fixture)
    assert str(caught.value) == 'the model "robot" has been deleted'


def test_using_a_kept_body_of_a_deleted_model_raises(world):
    base = world.get_model("robot").base

    world.delete_model("robot")

    assert base.name == "base"
    with pytest.raises(_core.GoneError, match="this body has been deleted"):
        _ = base.pose


def test_a_body_may_be_removed_by_a_thread_during_a_scan():
    """The scan gives the right ranges or raises; it never reads freed memory."""
    world = _core.World()
    world.add_layer([[3, -9, 3, 9]], 0xFFFF)
    fan = _core.BeamFan(-0.5, 2e-5, 50000)
    body = world.add_body("dynamic", (0, 0, 0))
    lidar = body.add_lidar(fan, (0, 0, 0), 20.0)
    is_over = threading.Event()

    def renew():
        nonlocal body, lidar
        while not is_over.is_set():
            with suppress(ReferenceError, RuntimeError):  # deleted, or in use by the other thread
                body.remove()
                body = world.add_body("dynamic", (0, 0, 0))
                lidar = body.add_lidar(fan, (0, 0, 0), 20.0)
                np.full(50000, 77.0, np.float32)  # may reuse the memory of the scan

    switch_interval = sys.getswitchinterval()
    sys.setswitchinterval(1e-6)
    thread = threading.Thread(target=renew)
    thread.start()
    try:
        for _ in range(2000):
            with suppress(ReferenceError, RuntimeError):
                ranges, _ = lidar.scan()
                assert ranges.shape == (50000,)
                assert ranges.min() == 3.0
                assert ranges.max() < 3.5
    finally:
        is_over.set()
        thread.join()
        sys.setswitchinterval(switch_interval)
