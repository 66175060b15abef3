"""Sensors with transforms that are sent once, on /tf_static."""

import math

import pytest

from flatland2d import Simulation
from flatland_server import messages
from flatland_server.transport.local_transport import LocalTransport

TFMessage = messages.get("tf2_msgs/TFMessage")
TransformStamped = messages.get("geometry_msgs/TransformStamped")

ANGLE = {"min": 0, "max": 1, "increment": 0.5}
SENSORS = {
    "lidar": {"type": "Laser", "range": 3, "origin": [1, 2, 0.5], "angle": ANGLE},
    "imu": {"type": "Imu"},
    "gps": {"type": "Gps"},
}


def robots(*namespaces, **keys):
    """A world of robots with all sensors, which have more keys."""
    base = {"name": "base", "footprints": [{"type": "circle", "radius": 0.1, "density": 1}]}
    plugins = [{"name": name, "body": "base", **SENSORS[name], **keys} for name in SENSORS]
    model = {"bodies": [base], "plugins": plugins}
    layers = [{"name": "map", "map": {"segments": [[0, 5, 5, 5]]}}]
    models = [{"name": name, "namespace": name, "model": model} for name in namespaces]
    return {"properties": {}, "layers": layers, "models": models}


def static_frames(simulation):
    message = simulation.last("/tf_static")
    return sorted(each.child_frame_id for each in message.transforms)


def test_all_mounts_are_in_one_message_and_none_on_tf():
    simulation = Simulation(robots("a", "b", static_tf=True), topics=["/tf"]).step(3)

    assert static_frames(simulation) == sorted(f"{ns}_{name}" for ns in "ab" for name in SENSORS)
    assert simulation.transport.transforms == {}
    latched = simulation.transport.last_latched("/tf_static")
    assert all(each.header.stamp.to_nsec() == 0 for each in latched.transforms)


def test_static_mounts_are_in_the_transforms_of_a_simulation():
    for static_tf in (True, False):
        world = robots("a", static_tf=static_tf)
        world["models"][0]["model"]["plugins"][0]["upside_down"] = True
        lidar = Simulation(world, topics=["/tf"]).step(2).transforms["a_lidar"]
        assert (lidar.parent, lidar.child, lidar.roll) == ("a_base", "a_lidar", math.pi)
        assert tuple(lidar.pose) == pytest.approx((1, 2, 0.5))
    silent = Simulation(robots("a", static_tf=True, broadcast_tf=False), topics=["/tf"]).step()
    assert silent.transforms == {}


@pytest.mark.parametrize(
    ("keys", "server", "is_static"),
    [({}, False, False), ({}, True, True), ({"static_tf": False}, True, False)],
)
def test_the_key_counts_before_the_servers_parameter(keys, server, is_static):
    params = {"~static_tf": server}
    simulation = Simulation(robots("a", **keys), params=params, topics=["/tf"]).step()

    names = {f"a_{name}" for name in SENSORS}
    assert set(simulation.transforms) == names
    assert set(simulation.transport.transforms) == (set() if is_static else names)


def test_mounts_vanish_with_their_robot_and_return_by_reset():
    simulation = Simulation(robots("a", "b", static_tf=True))
    simulation.delete("a")
    assert static_frames(simulation) == ["b_gps", "b_imu", "b_lidar"]

    simulation.reset()

    assert len(static_frames(simulation)) == 6


def test_static_transforms_of_all_publishers_are_merged():
    transport = LocalTransport()
    first, second = (
        transport.advertise("/tf_static", TFMessage, latch=True, queue_size=1) for _ in range(2)
    )

    def send(publisher, parent, *children):
        stamped = [TransformStamped(child_frame_id=child) for child in children]
        for each in stamped:
            each.header.frame_id = parent
        publisher.publish(TFMessage(stamped))
        return {
            each.child_frame_id: each.header.frame_id
            for each in transport.last("/tf_static").transforms
        }

    assert send(first, "map", "odom") == {"odom": "map"}
    assert send(second, "base", "eye", "ear") == {"odom": "map", "eye": "base", "ear": "base"}
    assert send(first, "head", "eye")["eye"] == "head"
    assert send(second, "base", "nose").keys() == {"odom", "eye", "ear", "nose"}
    second.close()
    assert transport.last("/tf_static").transforms[-1].child_frame_id == "eye"
    assert len(transport.last("/tf_static").transforms) == 2
