#pragma once

/// Limits on how fast a velocity may change and how large it may be.

#include "flatland_server/geometry.hpp"

namespace flatland {

/// A planar velocity at the end of a step, and its mean over the step, by which positions follow
/// the velocity's exact integral.
struct VelocityChange {
  Vec2 reached;
  Vec2 mean;
};

/// How fast a velocity may change, and how large it may be. Zero means no limit.
struct DynamicsLimits {
  double acceleration = 0.0;  ///< away from zero [m/s^2 or rad/s^2]
  double deceleration = 0.0;  ///< towards zero [m/s^2 or rad/s^2]
  double velocity = 0.0;      ///< largest magnitude [m/s or rad/s]

  /// Throws std::invalid_argument on a limit that is negative or not finite.
  void Check() const;

  /// From `current` on the straight way to `target`, `dt` seconds on. What leads towards zero speed
  /// takes the deceleration, what leads away from it the acceleration: a reversal is two movements.
  VelocityChange Approach(Vec2 current, Vec2 target, double dt) const;
  /// The same on a line; returns what is reached.
  double Approach(double current, double target, double dt) const {
    return Approach(Vec2{current, 0.0}, Vec2{target, 0.0}, dt).reached.x;
  }
};

}  // namespace flatland
