"""Mirror images of observations: as a robot sees a world in which left and right are changed."""

import math

import numpy as np
import pytest

pytest.importorskip("gymnasium")

from environments import make

from flatland2d import world_content
from flatland_gym.train import Mirror

DRIVES = {"DiffDrive": ([0.5, 0.8], [1, -1]), "OmniDrive": ([0.5, 0.3, 0.8], [1, -1, -1])}
FRONT = {"min": -math.pi / 2, "max": math.pi / 2, "increment": math.pi / 12}


def room(side, drive="DiffDrive", **laser):
    """The empty room with a ball that rolls; with a side of -1 left and right are changed."""
    content = world_content("package://flatland_gym/worlds/empty_room.yaml")
    plugins = content["models"][0]["model"]["plugins"]
    plugins[0] = {"type": drive, "name": "drive", "body": "base_link"}
    plugins[1].update(laser)
    footprint = {"type": "circle", "radius": 0.3, "density": 1}
    ball = {"name": "ball", "type": "kinematic", "footprints": [footprint]}
    rolls = {"type": "Tween", "name": "rolls", "body": "ball", "mode": "yoyo", "duration": 2}
    model = {"bodies": [ball], "plugins": [{**rolls, "delta": [0, -side, 0]}]}
    content["models"].append({"name": "ball", "pose": [2, side, 0], "model": model})
    return content


def driven(side, action, **arguments):
    """The environment and its observation after ten equal steps."""
    env = make(world=room(side, **arguments), neighbors=2)
    env.reset(options={"start": [0, 0.5 * side, 0.2 * side], "goal": [3, 2 * side]})
    for _ in range(10):
        observation = env.step(np.array(action, np.float32))[0]
    env.close()
    return env.navigation, observation


@pytest.mark.parametrize("drive", DRIVES)
@pytest.mark.parametrize("laser", [{}, {"angle": FRONT}, {"angle": FRONT, "upside_down": True}])
def test_the_mirror_image_is_seen_in_the_mirrored_world(drive, laser):
    action, signs = DRIVES[drive]
    navigation, seen = driven(1, action, drive=drive, **laser)
    _, expected = driven(-1, np.multiply(action, signs), drive=drive, **laser)

    mirror, images, actions = Mirror.of(navigation), seen[None].copy(), np.float32([action])
    mirror.turn(images, actions)

    assert not np.allclose(seen, expected, atol=0.1)
    np.testing.assert_allclose(images[0], expected, atol=2e-5)
    np.testing.assert_allclose(actions[0], np.multiply(action, signs), rtol=1e-6)


@pytest.mark.parametrize(
    "laser",
    [
        {"angle": {"min": -1.0, "max": 1.2, "increment": 0.1}},
        {"angle": FRONT, "origin": [0, 0, 0.1]},
        {"origin": [0, 0.1, 0]},
    ],
)
def test_a_lidar_off_the_axis_has_no_mirror_image(laser):
    navigation, _ = driven(1, [0.5, 0.8], **laser)
    assert Mirror.of(navigation) is None


def test_a_turned_but_symmetric_lidar_has_a_mirror_image():
    angle = {"min": -1.0, "max": 3.0, "increment": 0.5}
    navigation, _ = driven(1, [0.5, 0.8], angle=angle, origin=[0.1, 0, -1.0])
    assert navigation.robot.mirrored_beams == (8, 7, 6, 5, 4, 3, 2, 1, 0)
