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


ANCHOR = "expected the anchor on the wheel at its origin, found it at"


@pytest.mark.parametrize(
    ("key", "old", "new", "message"),
    [
        ("front_wheel_joint", ": front", ": left", "expected a revolute joint, found a weld joint"),
        ("front_wheel_joint", ": front", ": hub", '"base", found one of left_wheel and hub_cap'),
        ("front_wheel_joint", "base, anchor: [0, 0]", "base, anchor: [1, 2]", "found it at [1, 2]"),
        ("front_wheel_joint", "wheel, anchor: [0, 0]", "wheel, anchor: [1, 0]", f"{ANCHOR} [1, 0]"),
        ("rear_right_wheel_joint", ": right", ": hub", "expected a weld joint, found a revolute"),
        ("rear_left_wheel_joint", ": left", ": lefd", 'has no joint "lefd" (did you mean "left"?)'),
        ("rear_left_wheel_joint", "left_wheel, anchor: [0,", "left_wheel, anchor: [1,", ANCHOR),
        ("rear_right_wheel_joint", "right_wheel, anchor: [0,", "right_wheel, anchor: [1,", ANCHOR),
        ("body", ": base\n", ": bass\n", 'the model has no body "bass" (did you mean "base"?)'),
    ],
)
def test_wheels_unfit_for_a_tricycle_are_refused_by_their_key(files, key, old, new, message):
    if old.startswith(": "):
        old, new = f"{key}{old}", f"{key}{new}"
    found = refusal(files, replaced=(old, new)).split("\n")

    where = f"{line_of(f'    {key}: ')}: plugins[0].{key}: "
    assert [each for each in found if each.startswith(where) and message in each]


@pytest.mark.parametrize(
    ("left", "right", "message"),
    [
        ((0.0, 0.35), (0.0, -0.35), "expected the rear axle apart from the front wheel, found it"),
        ((-1.0, 0.35), (-1.1, -0.35), "expected the rear axle at right angles to the way from its"),
        ((-1.0, 0.35), (-1.0, -0.3), "found the rear wheels at [-1, 0.35] and [-1, -0.3]"),
        ((-1.0, 0.0), (-1.0, 0.0), "apart from each other, found both at [-1, 0]"),
    ],
    ids=["beside the front wheel", "aslant", "off the middle", "one rear wheel"],
)
def test_rear_wheels_that_form_no_axle_are_refused(files, left, right, message):
    found = refusal(files, left=left, right=right)

    assert found.startswith(f'{line_of("type: TricycleDrive")}: plugins[0] "drive": expected the')
    assert message in found
