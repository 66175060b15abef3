#pragma once

/// Drives a body as a car: with steered front wheels and a fixed rear axle.

#include <box2d/box2d.h>

#include <array>
#include <optional>

#include "base/geometry.hpp"
#include "motion/actuated_drive.hpp"
#include "motion/dynamics_limits.hpp"
#include "motion/steering.hpp"

namespace flatland {

/// A car with tyres that slip sideways, in proportion to their load: the single-track model "ST"
/// of CommonRoad (Althoff, Koschi and Manzinger, "CommonRoad: Composable Benchmarks for Motion
/// Planning on Roads", 2017; vehicle models, section 7). All but the height are above 0.
struct SingleTrack {
  double mass = 0.0;             ///< m [kg]
  double inertia = 0.0;          ///< I_z, about the centre of mass [kg m^2]
  double center_of_mass = 0.0;   ///< l_r, in front of the rear axle, behind the front axle [m]
  double height = 0.0;           ///< h, of the centre of mass [m]: acceleration shifts the load
  double friction = 0.0;         ///< mu
  double front_stiffness = 0.0;  ///< C_S,f, cornering stiffness [1/rad]
  double rear_stiffness = 0.0;   ///< C_S,r [1/rad]
};

struct AckermannSettings {
  double wheelbase = 0.0;        ///< from the rear axle to the front axle [m]
  double max_steer_angle = 0.0;  ///< of the magnitude of the steering angle, below pi/2 [rad]
  DynamicsLimits linear;         ///< of the speed [m/s, m/s^2]
  double jerk = 0.0;             ///< of the change of the acceleration [m/s^3]; 0 is no limit
  DynamicsLimits steering;       ///< of the steering rate [rad/s, rad/s^2]
  std::optional<SingleTrack> single_track;  ///< none: no tyre slips
  std::optional<ActuatorSettings> actuator{};
};

/// A command with its own limits; 0 means no limit.
struct AckermannCommand {
  double speed = 0.0;          ///< [m/s]
  double steer_angle = 0.0;    ///< of a wheel in the middle of the front axle [rad]
  double steering_rate = 0.0;  ///< the fastest [rad/s]
  double acceleration = 0.0;   ///< the greatest [m/s^2]
  double jerk = 0.0;           ///< the greatest [m/s^3]
};

/// The drive of one body, the origin of which is in the middle of the rear axle, with x forwards.
/// The speed is that of the rear axle or, with slip, of the centre of mass.
class AckermannDrive : public ActuatedDrive {
 public:
  /// Tyres slip when the car drives forwards at this speed or faster [m/s]. Otherwise they roll:
  /// the equations of slip are singular at rest, and unstable backwards.
  static constexpr double kSlipSpeed = 0.1;
  /// A longer step is integrated in several parts [s].
  static constexpr double kLongestPart = 0.01;

  AckermannDrive() = default;
  /// `wheels` are the joints that hold the steered wheels' bodies, which are rotated to show their
  /// angles, or null. Throws std::invalid_argument if a setting is not within its bounds.
  AckermannDrive(const AckermannSettings& settings, const std::array<b2RevoluteJoint*, 2>& wheels);

  /// Sets the motion to reach. Throws std::invalid_argument if a value is not finite, or a limit
  /// negative.
  void Command(const AckermannCommand& command);
  /// Present speed [m/s].
  double speed() const { return actuator_ ? actuator_->velocity().vx : speed_; }
  /// Present steering angle [rad], positive to the left.
  double steer_angle() const { return actuator_ ? actuator_->velocity().omega : steering_.angle; }
  /// Present angle between the velocity and the heading, at the centre of mass [rad].
  double slip_angle() const { return slip_.angle; }
  /// Sets all velocities and the commanded speed to zero at once; the steering angle stays.
  void Reset();
  /// The greatest speed and yaw rate that the body may have in the next step.
  Fastest GetFastest() const;

  /// Must be called when `other` replaces a joint, or when a joint is destroyed (`other` is null).
  void Replace(const b2Joint* joint, b2Joint* other) {
    for (b2RevoluteJoint*& each : wheels_) {
      if (joint == each) each = static_cast<b2RevoluteJoint*>(other);
    }
    ActuatedDrive::Replace(joint, other);
  }
  /// Copies everything but the joints of another drive.
  void TakeMotion(const AckermannDrive& other) {
    const auto wheels = wheels_;
    *this = other;
    wheels_ = wheels;
  }

  /// Sets the body's velocity for the next step of `dt` [s].
  void BeginStep(b2Body& body, double dt);
  /// Sets the body's velocity after the step, and places the steered wheels.
  void EndStep(b2Body& body);

  /// Writes or reads what it keeps from step to step; see archive.hpp.
  template <class Archive>
  void Serialize(Archive& archive) {
    archive(command_.speed, command_.steer_angle, command_.steering_rate, command_.acceleration,
            command_.jerk, speed_, acceleration_, steering_.angle, steering_.rate, slip_.yaw_rate,
            slip_.angle, motion_, actuator_);
  }
  /// Calls `visit` with each member that steps change and that can be copied byte by byte.
  template <class Visit>
  void ForEachPart(Visit visit) {
    visit(command_, speed_, acceleration_, steering_, slip_, motion_);
    if (actuator_) actuator_->ForEachPart(visit);
  }
  /// Calls `visit` with each setting.
  template <class Visit>
  void ForEachSetting(Visit visit) {
    visit(settings_.wheelbase, settings_.max_steer_angle);
    settings_.linear.ForEachSetting(visit);
    visit(settings_.jerk);
    settings_.steering.ForEachSetting(visit);
    if (settings_.single_track) {
      SingleTrack& car = *settings_.single_track;
      visit(car.mass, car.inertia, car.center_of_mass, car.height, car.friction,
            car.front_stiffness, car.rear_stiffness);
    }
    if (actuator_) actuator_->ForEachSetting(visit);
  }

 private:
  /// The state of a car with slip, besides speed and steering angle.
  struct Slip {
    double yaw_rate = 0.0;  // [rad/s]
    double angle = 0.0;     // at the centre of mass [rad]
  };

  /// Changes speed and acceleration in `dt` [s], towards a target [m/s].
  VelocityChange ChangeSpeed(double target, double dt);
  /// Advances the state by `dt` [s], towards a target (speed, 0, steering angle); returns the mean
  /// twist of the rear axle's middle, in its frame.
  Twist Advance(const Twist& target, double dt);
  /// The same for the slip, from a speed and a steering angle to the present ones.
  Twist AdvanceSlip(double from_speed, double from_angle, double dt);
  /// The twist of the rear axle's middle if the tyres roll.
  Twist Rolling(double speed, double angle) const;
  /// The twist of the rear axle's middle with slip.
  Twist Slipping(double speed, const Slip& slip) const;
  /// The twist at present.
  Twist Present() const;

  AckermannSettings settings_;
  std::array<b2RevoluteJoint*, 2> wheels_{};
  AckermannCommand command_;
  double speed_ = 0.0;         // within the limits [m/s]
  double acceleration_ = 0.0;  // likewise; with a limit of the jerk [m/s^2]
  SteeringState steering_;     // likewise
  Slip slip_;
};

}  // namespace flatland
