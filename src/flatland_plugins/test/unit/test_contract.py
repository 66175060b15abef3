"""Every built-in plugin keeps the contract of plugins, with all keys that it reads."""

import xml.etree.ElementTree as ElementTree
from pathlib import Path
from typing import Any, Dict

import pytest
import samples

from flatland_server.testing import check_plugin

pytestmark = pytest.mark.slow

PACKAGE = Path(__file__).resolve().parents[2]
DECLARED = [
    element.get("name", "")
    for element in ElementTree.parse(PACKAGE / "flatland_plugins.xml").iter("class")
]
NOISE: Dict[str, Any] = {
    "odom_pose_noise": [0.1, 0.1, 0.1],
    "odom_twist_noise": [0.1, 0.1, 0.1],
    "odom_drift": [0.1, 0.1, 0.1],
}
SLIP: Dict[str, Any] = {
    "odom_drift": {
        **{f"{a}_per_{b}": 0.1 for a in ("translation", "rotation") for b in ("metre", "radian")},
        "per_second": [0, 0, 0],
    },
    "odom_frame_id": "~odom",
    "enable_odom_tf_pub": True,
    "enable_twist_pub": True,
}
POST = """
bodies: [{name: post, type: static, footprints: [{type: circle, radius: 0.5, density: 1}]}]
plugins: [{type: ModelTfPublisher, name: tf}]
"""
BESIDE_A_POST = """
layers: [{name: map}]
models: [{name: post, model: post.yaml, pose: [0.5, 0, 0]}]
"""
VARIANTS = [
    ("BoolSensor", {"update_rate": 20}),
    ("Bumper", {"publish_all_collisions": False}),
    ("DiffDrive", NOISE),
    ("Imu", {"angular_velocity_noise": [0.1, 0.1, 0.1]}),
    ("Laser", {"noise_std_dev": 0.1, "upside_down": True}),
    ("ModelTfPublisher", {"publish_tf_world": True, "exclude": ["left_wheel"]}),
    ("Pedestrian", {"goals": [[3, 3], [0, 0]], "leg_radius": 0.12, "swing_radius": 0.05}),
    ("RandomWall", {"num_of_walls": 2}),
    ("TricycleDrive", SLIP),
    ("Tween", {"mode": "trigger"}),
]
"""Keys that switch on features that are off by default."""


WITH_JOINTS = ("AckermannDrive", "JointMotor", "JointStatePublisher", "ModelTfPublisher")
WITH_JOINTS += ("Pedestrian", "TricycleDrive")
OTHER_NAMES = {
    "Imu": {"update_rate"},
    "Pedestrian": {"base_body"},
    "PosePublisher": {"ground_truth_pub", "pub_rate"},
    "TricycleDrive": {"max_angular_velocity", "max_steer_acceleration"},
}
"""Aliases of keys, which cannot be given together with the keys."""


def complete_entry(name: str) -> Dict[str, Any]:
    """An entry with all keys of a plugin: as in the reference's sample, or with their defaults."""
    entry: Dict[str, Any] = {"type": name, "name": "plugin", **samples.PLUGINS[name][0]}
    for path, default in samples.defaults_of_plugin(name).items():
        if path in OTHER_NAMES.get(name, ()):
            continue
        *sections, key = path.split(".")
        place = entry
        for section in sections:
            place = place.setdefault(section, {})
        place.setdefault(key, default)
    return entry


def robot_of(name: str) -> Dict[str, Any]:
    """A robot with what a plugin needs, since each is loaded hundreds of times."""
    has_joints = name in WITH_JOINTS
    return samples.TRICYCLE if has_joints else {"bodies": samples.TRICYCLE["bodies"][:1]}


@pytest.mark.parametrize(("name", "keys"), [*((name, {}) for name in DECLARED), *VARIANTS])
def test_it_keeps_the_contract(name, keys):
    world = BESIDE_A_POST if keys and name in ("BoolSensor", "Bumper") else None
    place = {"model": robot_of(name), "world": world, "files": {"post.yaml": POST}}

    check_plugin({**complete_entry(name), **keys}, other_keys=OTHER_NAMES.get(name, ()), **place)
