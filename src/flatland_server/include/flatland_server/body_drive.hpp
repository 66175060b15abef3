#pragma once

/// Drives a body at a commanded velocity within limits, at every step, without Python.

#include <box2d/box2d.h>

#include "flatland_server/arc_motion.hpp"
#include "flatland_server/dynamics_limits.hpp"
#include "flatland_server/geometry.hpp"

namespace flatland {

/// What a body with a drive is told to do and does. Velocities are those of the body's origin, in
/// the body's frame.
class BodyDrive {
 public:
  BodyDrive() = default;
  /// `linear` limits the planar velocity as a vector. Throws std::invalid_argument on a limit that
  /// is negative or not finite.
  BodyDrive(const DynamicsLimits& linear, const DynamicsLimits& angular);

  /// The velocity to reach. Throws std::invalid_argument if it is not finite.
  void Command(const Twist& target);
  const Twist& target() const { return target_; }
  /// The velocity of now, on its way to the target.
  const Twist& velocity() const { return velocity_; }
  /// Stands still at once, with nothing commanded.
  void Reset();

  /// Sets the body's velocity for the coming step of `dt` seconds.
  void BeginStep(b2Body& body, double dt);
  void EndStep(b2Body& body);

 private:
  DynamicsLimits linear_;
  DynamicsLimits angular_;
  Twist target_;
  Twist velocity_;
  ArcMotion motion_;
  bool is_asleep_ = false;  // with nothing to do, for this step
};

}  // namespace flatland
