"""TricycleDrive: wheels that do not form a tricycle, and other wrong configurations."""

from typing import Any

import pytest
from forklift import MODEL, forklift

from flatland_server.exceptions import FlatlandError


def refusal(files, *keys: str, **options: Any) -> str:
    """The error of loading a forklift, without the names of folder and file."""
    with pytest.raises(FlatlandError) as caught:
        forklift(files, *keys, **options)
    return str(caught.value).replace(f"{files.folder}/robot.model.yaml:", "")


def line_of(key: str) -> int:
    """The line of one of the required keys."""
    return MODEL[: MODEL.index(key)].count("\n")


@pytest.mark.parametrize(
    ("replaced", "key", "message"),
    [
        pytest.param(
            ("front_wheel_joint: front", "front_wheel_joint: left"),
            "front_wheel_joint",
            "expected a revolute joint, found a weld joint",
            id="welded front wheel",
        ),
        pytest.param(
            ("rear_right_wheel_joint: right", "rear_right_wheel_joint: hub"),
            "rear_right_wheel_joint",
            "expected a weld joint, found a revolute joint",
            id="turning rear wheel",
        ),
        pytest.param(
            ("front_wheel_joint: front", "front_wheel_joint: hub"),
            "front_wheel_joint",
            'expected a joint of "base", found one of left_wheel and hub_cap',
            id="front wheel of another body",
        ),
        pytest.param(
            ("{name: base, anchor: [0, 0]}", "{name: base, anchor: [0.1, -0.2]}"),
            "front_wheel_joint",
            "expected the front wheel at the body's origin, found it at [0.1, -0.2]",
            id="front wheel ahead of the origin",
        ),
        pytest.param(
            ("{name: front_wheel, anchor: [0, 0]}", "{name: front_wheel, anchor: [0.1, 0]}"),
            "front_wheel_joint",
            "expected the anchor on the wheel at its origin, found it at [0.1, 0]",
            id="front wheel off its hub",
        ),
        pytest.param(
            ("{name: left_wheel, anchor: [0, 0]}", "{name: left_wheel, anchor: [0, -0.01]}"),
            "rear_left_wheel_joint",
            "expected the anchor on the wheel at its origin, found it at [0, -0.01]",
            id="rear left wheel off its hub",
        ),
        pytest.param(
            ("{name: right_wheel, anchor: [0, 0]}", "{name: right_wheel, anchor: [0, 0.01]}"),
            "rear_right_wheel_joint",
            "expected the anchor on the wheel at its origin, found it at [0, 0.01]",
            id="rear right wheel off its hub",
        ),
        pytest.param(
            ("rear_left_wheel_joint: left", "rear_left_wheel_joint: lefd"),
            "rear_left_wheel_joint",
            'the model has no joint "lefd" (did you mean "left"?); it has: front, left, right, hub',
            id="unknown joint",
        ),
        pytest.param(
            ("body: base", "body: bass"),
            "body: base",
            'the model has no body "bass" (did you mean "base"?); '
            "it has: base, front_wheel, left_wheel, right_wheel, hub_cap",
            id="unknown body",
        ),
    ],
)
def test_wheels_unfit_for_a_tricycle_are_refused_by_their_key(files, replaced, key, message):
    where = f"{line_of(key)}: plugins[0].{key.partition(':')[0]}"

    assert f"{where}: {message}" in refusal(files, replaced=replaced).split("\n")


@pytest.mark.parametrize(
    ("left", "right", "message"),
    [
        pytest.param(
            (0.0, 0.35),
            (0.0, -0.35),
            "expected the rear axle apart from the front wheel, found it there",
            id="wheels beside each other",
        ),
        pytest.param(
            (-1.0, 0.35),
            (-1.1, -0.35),
            "expected the rear axle at right angles to the way from its middle to the front wheel, "
            "found the rear wheels at [-1, 0.35] and [-1.1, -0.35]",
            id="aslant",
        ),
        pytest.param(
            (-1.0, 0.35),
            (-1.0, -0.3),
            "expected the rear axle at right angles to the way from its middle to the front wheel, "
            "found the rear wheels at [-1, 0.35] and [-1, -0.3]",
            id="off the middle",
        ),
        pytest.param(
            (-1.0, 0.0),
            (-1.0, 0.0),
            "expected the rear wheels apart from each other, found both at [-1, 0]",
            id="one rear wheel",
        ),
    ],
)
def test_rear_wheels_that_form_no_axle_are_refused(files, left, right, message):
    line = line_of("type: TricycleDrive")

    assert refusal(files, left=left, right=right) == f'{line}: plugins[0] "drive": {message}'
