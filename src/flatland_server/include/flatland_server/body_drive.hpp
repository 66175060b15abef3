#pragma once

/// Drives a body at a commanded velocity within limits, at every step, without Python.

#include <box2d/box2d.h>

#include "flatland_server/geometry.hpp"

namespace flatland {

/// How fast one component of a velocity may change, and how large it may be. Zero means no limit.
struct DynamicsLimits {
  double acceleration = 0.0;  ///< away from zero [m/s^2 or rad/s^2]
  double deceleration = 0.0;  ///< towards zero [m/s^2 or rad/s^2]
  double velocity = 0.0;      ///< largest magnitude [m/s or rad/s]

  /// The velocity `dt` seconds after `current` on the way to `target`. A change of sign is two
  /// movements: down to zero at the deceleration, and on with what is left of dt.
  double Approach(double current, double target, double dt) const;
};

/// What a body with a drive is told to do and does. Velocities are those of the body's origin, in
/// the body's frame.
class BodyDrive {
 public:
  BodyDrive() = default;
  /// Throws std::invalid_argument on a limit that is negative or not finite.
  BodyDrive(const DynamicsLimits& linear, const DynamicsLimits& angular);

  /// The velocity to reach. Throws std::invalid_argument if it is not finite.
  void Command(const Twist& target);
  const Twist& target() const { return target_; }
  /// The velocity of now, on its way to the target.
  const Twist& velocity() const { return velocity_; }
  /// Stands still at once, with nothing commanded.
  void Reset();

  /// Sets the body's velocity for the coming step of `dt` seconds, such that its origin moves along
  /// the arc of a constant twist: the end of the step lies on the arc itself, not on its tangent.
  void Apply(b2Body& body, double dt);

 private:
  DynamicsLimits linear_;
  DynamicsLimits angular_;
  Twist target_;
  Twist velocity_;
};

}  // namespace flatland
