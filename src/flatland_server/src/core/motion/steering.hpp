#pragma once

/// The angle of a steered wheel, moving to a commanded angle within limits.

#include "motion/dynamics_limits.hpp"

namespace flatland {

struct SteeringState {
  double angle = 0.0;  ///< [rad]
  double rate = 0.0;   ///< [rad/s]
};

/// The state `time` [s] after `from`, on the fastest way to rest at the angle `target` [rad] within
/// the limits: it speeds up at the acceleration to at most the velocity limit, and slows down at
/// the deceleration to stop at the target. If it is too fast to stop there, or moves away, it first
/// slows down to rest. In closed form, so steps of any length give the same motion.
SteeringState Steer(SteeringState from, double target, const DynamicsLimits& limits, double time);

}  // namespace flatland
