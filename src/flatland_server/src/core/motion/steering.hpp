#pragma once

/// A steered wheel: its angle, moving to a commanded angle within limits, and its body.

#include <box2d/box2d.h>

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

/// Places the wheel that a joint holds to `body` at an angle to it [rad], as far as the joint's
/// limits allow, moving with the body.
void PlaceSteeredWheel(b2RevoluteJoint& joint, const b2Body& body, double angle);

}  // namespace flatland
