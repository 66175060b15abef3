"""AckermannDrive: a body that steers by its front wheels, as a car."""

import math
from typing import Any, List, Optional, Tuple

from flatland_plugins.drive_config import read_dynamics
from flatland_plugins.twist_drive import TwistDrive
from flatland_plugins.wheel_joints import TOLERANCE, get_wheel
from flatland_server import CoreDrive, Joint, ModelBody, YamlReader

_WHEELS = ("front_left_wheel_joint", "front_right_wheel_joint")


class AckermannDrive(TwistDrive):
    """A car: commanded by a speed [m/s] and a steering angle [rad], or by a Twist.

    The body's origin is in the middle of the rear axle, x forwards. Without the section
    `single_track`, no tyre slips: the bicycle model of Siciliano et al., "Robotics", 11.2.2. With
    it, tyres slip sideways as in the model "ST" of CommonRoad; see ackermann_drive.hpp.
    `linear_dynamics` limits the speed, `angular_dynamics` how the steering angle changes.
    """

    def add_drive(self, config: YamlReader, body: ModelBody) -> CoreDrive:
        self._wheelbase = config.get_float("wheelbase", above=0.0)
        max_steer_angle = config.get_float("max_steer_angle", above=0.0)
        if max_steer_angle >= math.pi / 2:
            expected = "expected an angle in rad below a right one"
            config.problem(f"{expected}, found {max_steer_angle:g}", "max_steer_angle")
        topics = (
            config.get_topic("ackermann_sub", "ackermann_cmd"),
            config.get_topic("ackermann_drive_sub", "ackermann_drive"),
        )
        self._twist_has_angle = config.get_bool("cmd_angle_instead_rotvel", False)
        linear, angular = config.read_once(read_dynamics)
        jerk_limit = config.get_float("jerk_limit", 0.0, minimum=0.0)
        wheels = self._steered_wheels(config, body)
        single_track = self._single_track(config)
        actuators = self.read_actuators(config, body, is_steered=True)
        config.finish()
        if single_track is not None and body.config.type == "dynamic":
            mass, inertia, center = single_track[:3]
            body.physics_body.set_mass(mass, inertia=inertia, local_center=(center, 0.0))
        self._car = body.physics_body.add_ackermann(
            self._wheelbase,
            max_steer_angle,
            wheels=[each.physics_joint for each in wheels],
            linear_limits=linear,
            jerk_limit=jerk_limit,
            steering_limits=angular,
            single_track=single_track,
            actuators=actuators,
        )
        kinds = ("AckermannDriveStamped", "AckermannDrive")
        for topic, kind, obey in zip(topics, kinds, (self._on_stamped, self._on_ackermann)):
            self.subscribe_commands(topic, f"ackermann_msgs/{kind}", obey)
        limits = (linear.velocity_limit, max_steer_angle)
        return CoreDrive(self._car, (0, 1), limits, self._actuators.is_random)

    def on_twist(self, twist: Any) -> None:
        """Steers so as to turn at the rate of a Twist: v tan(angle) = wheelbase * yaw rate."""
        speed, turn = twist.linear.x, twist.angular.z
        if not self._twist_has_angle and math.isfinite(turn):
            turn = math.atan(self._wheelbase * turn / speed) if speed else 0.0
        self.command(speed, turn)

    def command(self, speed: float, steer_angle: float) -> None:
        """Drives at a speed [m/s] and steers to an angle [rad], positive to the left."""
        self._car.command(speed, steer_angle)

    def describe(self, command: Any) -> str:
        if hasattr(command, "linear"):
            return super().describe(command)
        drive = getattr(command, "drive", command)
        return f"speed={drive.speed} steering_angle={drive.steering_angle}"

    def _on_stamped(self, stamped: Any) -> None:
        self._on_ackermann(stamped.drive)

    def _on_ackermann(self, drive: Any) -> None:
        self._car.command_within(
            drive.speed,
            drive.steering_angle,
            drive.steering_angle_velocity,
            drive.acceleration,
            drive.jerk,
        )

    def _steered_wheels(self, config: YamlReader, body: ModelBody) -> List[Joint]:
        """The joints of the front wheels, as far as they are given."""
        joints = []
        for key in _WHEELS:
            wheel = get_wheel(self, config, key, body, "revolute", "")
            if wheel is None:
                continue
            joint, (x, _) = wheel
            joints.append(joint)
            if abs(x - self._wheelbase) > TOLERANCE:
                config.problem(
                    f"expected an anchor on the front axle, at x = {self._wheelbase:g}, found "
                    f"x = {x:g}",
                    key,
                )
        return joints

    def _single_track(self, config: YamlReader) -> Optional[Tuple[float, ...]]:
        """The numbers of a car with slip, as the core takes them; None: without slip."""
        section = config.get_section("single_track")
        if not config.has("single_track"):
            return None
        numbers = (
            section.get_float("mass", above=0.0),
            section.get_float("inertia", above=0.0),
            section.get_float("center_of_mass", above=0.0),
            section.get_float("height", 0.0, minimum=0.0),
            section.get_float("friction", above=0.0),
            section.get_float("front_stiffness", above=0.0),
            section.get_float("rear_stiffness", above=0.0),
        )
        if section.is_sound and numbers[2] >= self._wheelbase:
            section.problem(
                f"expected a distance from the rear axle below the wheelbase, {self._wheelbase:g}, "
                f"found {numbers[2]:g}",
                "center_of_mass",
            )
        section.finish()
        return numbers
