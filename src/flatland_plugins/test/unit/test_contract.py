"""Every built-in plugin keeps the contract of plugins, with the keys that docs/plugins.md shows."""

import re
import xml.etree.ElementTree as ElementTree
from pathlib import Path
from typing import Any, Dict

import pytest
import yaml

from flatland_server.testing import check_plugin

pytestmark = pytest.mark.slow

PACKAGE = Path(__file__).resolve().parents[2]
PAGE = (PACKAGE.parents[1] / "docs" / "plugins.md").read_text(encoding="utf-8")
DECLARED = [
    element.get("name", "")
    for element in ElementTree.parse(PACKAGE / "flatland_plugins.xml").iter("class")
]
[ROBOT] = re.findall(r"```yaml\n# file: robot.model.yaml\n(.*?)```", PAGE, re.DOTALL)
NOISE: Dict[str, Any] = {
    "odom_pose_noise": [0.1, 0.1, 0.1],
    "odom_twist_noise": [0.1, 0.1, 0.1],
    "odom_drift": [0.1, 0.1, 0.1],
}
SLIP: Dict[str, Any] = {
    "odom_drift": {
        "translation_per_metre": 0.1,
        "translation_per_radian": 0.1,
        "rotation_per_metre": 0.1,
        "rotation_per_radian": 0.1,
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
    ("RandomWall", {"num_of_walls": 2}),
    ("TricycleDrive", SLIP),
    ("Tween", {"mode": "trigger"}),
]
"""Keys that make a plugin do what it does not do by default."""


def section(name: str) -> str:
    """What docs/plugins.md says of a plugin."""
    [text] = re.findall(rf"^### {name}$(.*?)(?=^###? |\Z)", PAGE, re.DOTALL | re.MULTILINE)
    return text


def documented_entry(name: str) -> Dict[str, Any]:
    """The entry that docs/plugins.md shows; keys shared with DiffDrive are shown there alone."""
    [block] = re.findall(r"```yaml\n# in \S+\n(.*?)```", section(name), re.DOTALL)
    [entry] = yaml.safe_load(block)["plugins"]
    shared = documented_entry("DiffDrive") if "[DiffDrive](#diffdrive)" in section(name) else {}
    return {**shared, **entry}


def prose_keys(name: str) -> set:
    """What the text around the entry mentions, such as deprecated keys."""
    return set(re.findall(r"`(\w+)`", section(name)))


@pytest.mark.parametrize("name", DECLARED)
def test_it_keeps_the_contract(name):
    check_plugin(documented_entry(name), other_keys=prose_keys(name), model=ROBOT)


@pytest.mark.slow
@pytest.mark.parametrize(("name", "keys"), VARIANTS, ids=[name for name, _ in VARIANTS])
def test_it_keeps_the_contract_otherwise_configured(name, keys):
    entry = {**documented_entry(name), **keys}
    world = BESIDE_A_POST if name in ("BoolSensor", "Bumper") else None

    check_plugin(
        entry, other_keys=prose_keys(name), model=ROBOT, world=world, files={"post.yaml": POST}
    )
