#pragma once

/// The angle of a steered wheel on its way to a commanded one.

#include "flatland_server/dynamics_limits.hpp"

namespace flatland {

struct SteeringState {
  double angle = 0.0;  ///< [rad]
  double rate = 0.0;   ///< [rad/s]
};

/// Where a steering is `time` seconds after `from` on the fastest way to rest at `target` within
/// the limits: up to the velocity limit at the acceleration, along it, and down to rest at the
/// deceleration, such that it stops on the target. If it is too fast to stop there, or moves the
/// other way, it first slows down to rest. In closed form: steps of any length give the same
/// motion.
SteeringState Steer(SteeringState from, double target, const DynamicsLimits& limits, double time);

}  // namespace flatland
