#pragma once

/// Drives a body as a tricycle: with a steered front wheel and a fixed rear axle.

#include <box2d/box2d.h>

#include <limits>
#include <optional>

#include "base/geometry.hpp"
#include "motion/actuated_drive.hpp"
#include "motion/dynamics_limits.hpp"
#include "motion/steering.hpp"

namespace flatland {

struct TricycleSettings {
  Vec2 rear_axle;  ///< its middle, in the body's frame; the front wheel is at the origin [m]
  double max_steer_angle = 0.0;  ///< of the magnitude of the steering angle [rad]; 0 is no limit
  DynamicsLimits linear;         ///< of the front wheel's speed [m/s, m/s^2]
  DynamicsLimits steering;       ///< of the steering rate [rad/s, rad/s^2]
  std::optional<ActuatorSettings> actuator{};
};

/// The drive of one body. The front wheel rolls in its own direction, and the rear axle does not
/// slip sideways. Forward is from the rear axle to the front wheel.
class TricycleDrive : public ActuatedDrive {
 public:
  TricycleDrive() = default;
  /// `front_wheel` is the joint that holds the front wheel's body, which is rotated to show the
  /// steering angle, or null. Throws std::invalid_argument if a setting is not finite or negative,
  /// or the rear axle is at the front wheel.
  TricycleDrive(const TricycleSettings& settings, b2RevoluteJoint* front_wheel);

  /// Sets the speed of the front wheel [m/s] and the steering angle [rad] to reach. Throws
  /// std::invalid_argument if one is not finite.
  void Command(double speed, double angle);
  /// Present speed of the front wheel [m/s].
  double speed() const { return actuator_ ? actuator_->velocity().vx : speed_; }
  /// Present steering angle [rad], positive to the left.
  double steer_angle() const { return actuator_ ? actuator_->velocity().omega : steering_.angle; }
  /// The greatest speed and yaw rate that it may have in the next step.
  Fastest GetFastest() const;
  /// Sets the speed, the steering rate and the commanded speed to zero at once; the steering angle
  /// stays.
  void Reset();

  /// Must be called when `other` replaces a joint, or when a joint is destroyed (`other` is null).
  /// Without its joint, the front wheel is not rotated any more.
  void Replace(const b2Joint* joint, b2Joint* other) {
    if (joint == front_wheel_) front_wheel_ = static_cast<b2RevoluteJoint*>(other);
    ActuatedDrive::Replace(joint, other);
  }

  /// Copies everything but the joint of another drive.
  void TakeMotion(const TricycleDrive& other) {
    b2RevoluteJoint* const joint = front_wheel_;
    *this = other;
    front_wheel_ = joint;
  }

  /// Sets the body's velocity for the next step of `dt` [s].
  void BeginStep(b2Body& body, double dt);
  /// Sets the body's velocity after the step, and places the front wheel.
  void EndStep(b2Body& body);

  /// Writes or reads what it keeps from step to step; see archive.hpp.
  template <class Archive>
  void Serialize(Archive& archive) {
    archive(target_speed_, target_angle_, speed_, steering_.angle, steering_.rate, motion_,
            actuator_);
  }
  /// Calls `visit` with each member that steps change and that can be copied byte by byte.
  template <class Visit>
  void ForEachPart(Visit visit) {
    visit(target_speed_, target_angle_, speed_, steering_, motion_);
    if (actuator_) actuator_->ForEachPart(visit);
  }
  /// Calls `visit` with each setting but the place of the rear axle.
  template <class Visit>
  void ForEachSetting(Visit visit) {
    visit(settings_.max_steer_angle);
    settings_.linear.ForEachSetting(visit);
    settings_.steering.ForEachSetting(visit);
    if (actuator_) actuator_->ForEachSetting(visit);
  }

 private:
  /// Twist of the body's origin, in its frame, for a speed [m/s] and angle [rad] of the front
  /// wheel.
  Twist TwistAt(double speed, double angle);

  TricycleSettings settings_;
  b2RevoluteJoint* front_wheel_ = nullptr;
  double wheelbase_ = 1.0;     // [m]
  double heading_ = 0.0;       // forward direction, in the body's frame [rad]
  double target_speed_ = 0.0;  // [m/s]
  double target_angle_ = 0.0;  // [rad]
  double speed_ = 0.0;         // within the limits [m/s]
  SteeringState steering_;     // likewise

  /// Of the last `TwistAt`; a tricycle seldom steers.
  struct {
    double angle = std::numeric_limits<double>::quiet_NaN();  // of the front wheel [rad]
    Rotation rotation{0.0};                                   // of its direction
    double sin = 0.0;
  } direction_;
};

}  // namespace flatland
