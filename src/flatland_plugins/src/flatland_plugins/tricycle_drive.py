"""TricycleDrive: a body on a steered front wheel and an unsteered rear axle."""

import math
from typing import Any

from flatland_plugins.drive_config import DynamicsLimits, read_dynamics
from flatland_plugins.twist_drive import TwistDrive
from flatland_plugins.wheel_joints import TOLERANCE, get_wheel
from flatland_server import CoreDrive, ModelBody, Point, YamlReader

_DEPRECATED = (
    ("max_angular_velocity", "velocity_limit"),
    ("max_steer_acceleration", "acceleration_limit"),
)


class TricycleDrive(TwistDrive):
    """A Twist's linear.x is the front wheel's speed [m/s], its angular.z the wheel's angle [rad].

    The body's origin is at the front wheel. The geometry is read from the model's joints: the front
    wheel is attached by a revolute joint at the origin, the rear wheels by welds at the ends of the
    rear axle, which is perpendicular to the line from its middle to the front wheel. The front
    wheel's body is turned for display only. `angular_dynamics` limits how the steering angle
    changes, `linear_dynamics` the speed.
    """

    publishes_twist = False
    publishes_transform = False

    def add_drive(self, config: YamlReader, body: ModelBody) -> CoreDrive:
        front = get_wheel(self, config, "front_wheel_joint", body, "revolute")
        left = get_wheel(self, config, "rear_left_wheel_joint", body, "weld")
        right = get_wheel(self, config, "rear_right_wheel_joint", body, "weld")
        if front is not None and math.hypot(*front[1]) > TOLERANCE:
            x, y = front[1]
            config.problem(
                f"expected the front wheel at the body's origin, found it at [{x:g}, {y:g}]",
                "front_wheel_joint",
            )
        axle = (0.0, 0.0)
        if left is not None and right is not None:
            axle = self._rear_axle(config, left[1], right[1])
        max_steer_angle = config.get_float("max_steer_angle", 0.0, minimum=0.0)
        config.warn_of_degrees(max_steer_angle, "max_steer_angle")
        linear, angular = read_dynamics(config)
        angular = _with_deprecated(config, angular)
        actuators = self.read_actuators(config, body, is_steered=True)
        config.finish()
        assert front is not None  # or there was a problem
        self._tricycle = body.physics_body.add_tricycle(
            front[0].physics_joint,
            axle,
            max_steer_angle,
            linear,
            angular,
            actuators,
        )
        limits = (linear.velocity_limit, max_steer_angle)
        return CoreDrive(self._tricycle, (0, 1), limits, self._actuators.is_random)

    def on_twist(self, twist: Any) -> None:
        self.command(twist.linear.x, twist.angular.z)

    def command(self, speed: float, steer_angle: float) -> None:
        """Sets the speed [m/s] and the angle [rad] of the front wheel."""
        self._tricycle.command(speed, steer_angle)

    def _rear_axle(self, config: YamlReader, left: Point, right: Point) -> Point:
        """The middle of the rear axle, in the body's frame."""
        middle = (left[0] + right[0]) / 2, (left[1] + right[1]) / 2
        wheelbase = math.hypot(*middle)
        width = math.dist(left, right)
        aslant = middle[0] * (left[0] - right[0]) + middle[1] * (left[1] - right[1])
        if wheelbase < TOLERANCE:
            config.problem("expected the rear axle apart from the front wheel, found it there")
        elif width < TOLERANCE:
            config.problem(
                "expected the rear wheels apart from each other, "
                f"found both at [{left[0]:g}, {left[1]:g}]"
            )
        elif abs(aslant) > TOLERANCE * wheelbase * width:
            config.problem(
                "expected the rear axle at right angles to the way from its middle to the front "
                f"wheel, found the rear wheels at [{left[0]:g}, {left[1]:g}] and "
                f"[{right[0]:g}, {right[1]:g}]"
            )
        return middle


def _with_deprecated(config: YamlReader, angular: DynamicsLimits) -> DynamicsLimits:
    """The limits of the steering, including those given by deprecated keys."""
    for old, new in _DEPRECATED:
        value = config.get_float(old, 0.0, minimum=0.0)
        if not config.has(old):
            continue
        config.warn(f"is deprecated; write angular_dynamics.{new}", old)
        if getattr(angular, new) == 0.0:
            angular = angular._replace(**{new: value})
            if new == "acceleration_limit" and angular.deceleration_limit == 0.0:
                angular = angular._replace(deceleration_limit=value)
    return angular
