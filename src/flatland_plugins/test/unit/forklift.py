"""A forklift with a TricycleDrive, for its tests: the model, and readings of its state."""

import math
from typing import Any, Tuple

WHEELBASE, HALF_TRACK = 1.1, 0.35

# A small forklift: a body of 280 kg and wheels of 5 kg.
BODY_SHAPE = "[[0.2, -0.4], [0.2, 0.4], [-1.2, 0.4], [-1.2, -0.4]]"
WHEEL_SHAPE = "[[-0.1, -0.03], [0.1, -0.03], [0.1, 0.03], [-0.1, 0.03]]"
WHEEL = f"footprints: [{{type: polygon, points: {WHEEL_SHAPE}, density: 400}}]"

MODEL = """
bodies:
  - {{name: base, footprints: [{{type: polygon, points: {body_shape}, density: 250}}]}}
  - {{name: front_wheel, {wheel}}}
  - {{name: left_wheel, pose: [{left_x}, {left_y}, 0], {wheel}}}
  - {{name: right_wheel, pose: [{right_x}, {right_y}, 0], {wheel}}}
  - {{name: hub_cap, pose: [{left_x}, {left_y}, 0],
     footprints: [{{type: circle, radius: 0.05, density: 10, layers: []}}]}}
joints:
  - {{type: revolute, name: front, {front}}}
  - {{type: weld, name: left, bodies: [{{name: left_wheel, anchor: [0, 0]}},
      {{name: base, anchor: [{left_x}, {left_y}]}}]}}
  - {{type: weld, name: right, bodies: [{{name: base, anchor: [{right_x}, {right_y}]}},
      {{name: right_wheel, anchor: [0, 0]}}]}}
  - {{type: revolute, name: hub, bodies: [{{name: left_wheel, anchor: [0, 0]}},
      {{name: hub_cap, anchor: [0, 0]}}]}}
plugins:
  - type: TricycleDrive
    name: drive
    body: base
    front_wheel_joint: front
    rear_left_wheel_joint: left
    rear_right_wheel_joint: right
    {keys}
"""
FIRST_LINE = MODEL[: MODEL.index("{keys}")].count("\n")
"""The line of the file in which the keys of a test begin."""
FRONT = "bodies: [{name: front_wheel, anchor: [0, 0]}, {name: base, anchor: [0, 0]}]"
FRONT_REVERSED = "bodies: [{name: base, anchor: [0, 0]}, {name: front_wheel, anchor: [0, 0]}]"


def forklift(
    files,
    *keys: str,
    left: Tuple[float, float] = (-WHEELBASE, HALF_TRACK),
    right: Tuple[float, float] = (-WHEELBASE, -HALF_TRACK),
    front: str = FRONT,
    entry: str = "",
    replaced: Tuple[str, str] = ("", ""),
    **options: Any,
):
    """A world with a forklift; adds keys to its drive, and replaces a string of its file."""
    text = MODEL.lstrip("\n").format(
        body_shape=BODY_SHAPE, wheel=WHEEL, front=front, keys="\n    ".join(keys),
        left_x=left[0], left_y=left[1], right_x=right[0], right_y=right[1],
    )  # fmt: skip
    assert replaced[0] in text
    files.write("robot.model.yaml", text.replace(*replaced))
    return files.load_models({"robot": f"model: robot.model.yaml{entry}"}, **options)


def steer_angle(robot) -> float:
    """The angle of the displayed front wheel relative to the body [rad]."""
    wheel, base = (robot.model().get_body(name).pose.yaw for name in ("front_wheel", "base"))
    return math.remainder(wheel - base, math.tau)


def twist_at(speed: float, angle: float, wheelbase: float = WHEELBASE) -> Tuple[float, ...]:
    """The velocity of the body at the front wheel, such that the rear axle does not slip.

    The front wheel goes where it points, (v cos a, v sin a); the axle, L behind it, has the lateral
    velocity v sin a - L omega, which is zero.
    """
    across = speed * math.sin(angle)
    return speed * math.cos(angle), across, across / wheelbase


LINEAR = "linear_dynamics: {acceleration_limit: 0.5, deceleration_limit: 0.8}"
# 0.6 rad: 0.25 rad up to the largest rate, 0.225 along, 0.125 down; back -1 rad: 0.625 along.
STEERING = "angular_dynamics: {acceleration_limit: 0.5, deceleration_limit: 1, velocity_limit: 0.5}"
