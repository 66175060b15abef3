#pragma once

/// Drives a body on a steered front wheel and an unsteered rear axle, at every step.

#include <box2d/box2d.h>

#include "flatland_server/arc_motion.hpp"
#include "flatland_server/dynamics_limits.hpp"
#include "flatland_server/geometry.hpp"
#include "flatland_server/steering.hpp"

namespace flatland {

struct TricycleSettings {
  Vec2 rear_axle;  ///< its middle, in the body's frame, whose origin is at the front wheel [m]
  double max_steer_angle = 0.0;  ///< largest magnitude of the steering angle [rad]; 0 is no limit
  DynamicsLimits linear;         ///< of the front wheel's speed
  DynamicsLimits steering;       ///< of the steering's rate and its change
};

/// A tricycle: the front wheel rolls where it points, the rear axle only forwards and backwards.
/// The body's heading is from the rear axle to the front wheel.
class TricycleDrive {
 public:
  TricycleDrive() = default;
  /// `front_wheel` is the joint that holds the wheel that is turned for show, or null. Throws
  /// std::invalid_argument if a setting is not finite, negative, or the rear axle is at the front
  /// wheel.
  TricycleDrive(const TricycleSettings& settings, b2RevoluteJoint* front_wheel);

  /// The speed of the front wheel [m/s] and its angle [rad] to reach. Throws std::invalid_argument
  /// if one is not finite.
  void Command(double speed, double angle);
  double speed() const { return speed_; }
  double steer_angle() const { return steering_.angle; }
  /// Stands still at once, with nothing commanded; the wheel stays as it is steered.
  void Reset();

  /// The joint is gone: no wheel is turned any more.
  void Forget(const b2Joint* joint) {
    if (joint == front_wheel_) front_wheel_ = nullptr;
  }

  void BeginStep(b2Body& body, double dt);
  void EndStep(b2Body& body);

 private:
  /// The twist of the body's origin, in its frame, at a speed and an angle of the front wheel.
  Twist TwistAt(double speed, double angle) const;

  TricycleSettings settings_;
  b2RevoluteJoint* front_wheel_ = nullptr;
  double wheelbase_ = 1.0;
  double heading_ = 0.0;  // of the way from the rear axle to the front wheel, in the body's frame
  double target_speed_ = 0.0;
  double target_angle_ = 0.0;
  double speed_ = 0.0;
  SteeringState steering_;
  ArcMotion motion_;
};

}  // namespace flatland
