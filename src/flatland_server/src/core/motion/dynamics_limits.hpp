#pragma once

/// Limits on how fast a velocity may change and how large it may be.

#include "base/geometry.hpp"

namespace flatland {

/// A planar velocity after a step, and its exact mean over the step.
struct VelocityChange {
  Vec2 reached;  ///< at the end of the step [m/s]
  Vec2 mean;     ///< times the step, it is the distance covered [m/s]
};

/// The greatest speed and yaw rate of something.
struct Fastest {
  double squared_speed = 0.0;  ///< [m^2/s^2]
  double omega = 0.0;          ///< [rad/s]
};

/// Limits of a velocity and its rate of change. Zero means no limit.
struct DynamicsLimits {
  double acceleration = 0.0;  ///< away from zero [m/s^2 or rad/s^2]
  double deceleration = 0.0;  ///< towards zero [m/s^2 or rad/s^2]
  double velocity = 0.0;      ///< of the magnitude [m/s or rad/s]

  /// Throws std::invalid_argument if a limit is negative or not finite.
  void Check() const;

  /// Calls `visit` with each number.
  template <class Visit>
  void ForEachSetting(Visit visit) {
    visit(acceleration, deceleration, velocity);
  }
  /// A speed or rate, clamped to the velocity limit.
  double Limited(double speed) const {
    return velocity > 0.0 && speed > velocity ? velocity : speed;
  }
  /// The velocity after `dt` [s], changing from `current` along a straight line to `target` [m/s].
  /// Where the speed falls the deceleration applies, where it rises the acceleration: a reversal
  /// consists of both.
  VelocityChange Approach(Vec2 current, Vec2 target, double dt) const;
  /// The same for a scalar velocity; returns the velocity reached.
  double Approach(double current, double target, double dt) const {
    return Approach(Vec2{current, 0.0}, Vec2{target, 0.0}, dt).reached.x;
  }
};

}  // namespace flatland
