"""ModelTfPublisher: the frames of a model's bodies."""

import math
from typing import Any, Dict

import pytest
from logged import warnings

from flatland_server.geometry import Pose

TF = "type: ModelTfPublisher, name: tf"
MODEL = """
bodies:
  - {name: base, pose: [1, 0, 0.5], footprints: [{type: circle, radius: 0.1, density: 1}]}
  - {name: arm, pose: [0, 2, 0], footprints: [{type: circle, radius: 0.1, density: 1}]}
  - {name: hand, pose: [3, 2, -1], footprints: [{type: circle, radius: 0.1, density: 1}]}
plugins:
"""
BODIES = {"base": (1.0, 0.0, 0.5), "arm": (0.0, 2.0, 0.0), "hand": (3.0, 2.0, -1.0)}
"""Their poses in the model; the model stands turned by `HEADING` at (10, 20)."""
HEADING = 0.25


def load(files, *plugins: str, namespace: str = "", **options: Any):
    """A world with a robot of three bodies."""
    files.write("robot.yaml", MODEL + "".join(f"  - {{{plugin}}}\n" for plugin in plugins))
    entry = f"model: robot.yaml, namespace: '{namespace}', pose: [10, 20, {HEADING}]"
    return files.load_models({"robot": entry}, **options)


def frames(simulation) -> Dict[str, str]:
    """The parent of each frame."""
    return {child: t.parent for child, t in simulation.transport.transforms.items()}


@pytest.mark.parametrize("reference", ["base", "arm", "hand"])
def test_bodies_are_placed_in_the_frame_of_the_reference(files, reference):
    robot = load(files, f"{TF}, reference: {reference}").run()

    children = {name for name in BODIES if name != reference}
    assert frames(robot) == dict.fromkeys(children, reference)
    for child in children:
        expected = Pose(*BODIES[reference]).inverse().compose(Pose(*BODIES[child]))
        pose = robot.transport.transforms[child].pose
        assert tuple(pose) == pytest.approx(tuple(expected), abs=1e-5)


def test_the_world_is_the_parent_of_the_reference_if_asked_to(files):
    robot = load(files, f"{TF}, reference: arm, publish_tf_world: true").run()

    assert frames(robot) == {"arm": "map", "base": "arm", "hand": "arm"}
    x, y = 10 - 2 * math.sin(HEADING), 20 + 2 * math.cos(HEADING)
    assert tuple(robot.transport.transforms["arm"].pose) == pytest.approx((x, y, HEADING), abs=1e-5)


def test_excluded_bodies_have_no_frame(files):
    assert frames(load(files, f"{TF}, exclude: [hand]").run()) == {"arm": "base"}
    world = f"{TF}, publish_tf_world: true, exclude: "
    assert frames(load(files, f"{world}[arm, hand]").run()) == {"base": "map"}
    assert frames(load(files, f"{world}[base]").run()) == {"arm": "base", "hand": "base"}


def test_frames_follow_their_bodies(files):
    robot = load(files, f"{TF}, publish_tf_world: true")
    robot.model().get_body("hand").physics_body.velocity = (1.0, 0.0, 0.0)

    robot.run(1.0)

    transforms = robot.transport.transforms
    hand = transforms["base"].pose.compose(transforms["hand"].pose)
    # The transform of time t is made before the step from t on.
    start = 3 * math.cos(HEADING) - 2 * math.sin(HEADING) + 10
    assert transforms["hand"].nanoseconds == 995_000_000
    assert hand.x == pytest.approx(start + 0.995, abs=1e-3)


@pytest.mark.parametrize("seconds", [0.0, 0.1])
def test_two_parents_of_the_base_frame_cause_a_warning(files, caplog, seconds):
    drive = "type: DiffDrive, name: drive, body: base"

    load(files, drive, f"{TF}, publish_tf_world: true").run(seconds)

    [message] = warnings(caplog)
    for word in ('"base"', "robot/drive", '"odom"', "robot/tf", '"map"'):
        assert word in message


def test_a_drive_beside_it_is_no_trouble_without_the_world(files, caplog):
    load(files, "type: DiffDrive, name: drive, body: base", TF).run(0.1)

    assert warnings(caplog) == []
