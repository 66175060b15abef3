#include "motion/steered_wheel.hpp"

#include <algorithm>

#include "base/geometry.hpp"

namespace flatland {

void PlaceSteeredWheel(b2RevoluteJoint& joint, const b2Body& body, double angle) {
  const bool wheel_is_b = joint.GetBodyA() == &body;
  b2Body& wheel = wheel_is_b ? *joint.GetBodyB() : *joint.GetBodyA();
  if (joint.IsLimitEnabled()) {  // of b's angle minus a's, whole rotations included
    const double lower = wheel_is_b ? joint.GetLowerLimit() : -joint.GetUpperLimit();
    const double upper = wheel_is_b ? joint.GetUpperLimit() : -joint.GetLowerLimit();
    const double middle = 0.5 * (lower + upper);
    angle = std::clamp(middle + WrappedAngle(angle - middle), lower, upper);
  }
  const b2Vec2 hub = wheel_is_b ? joint.GetLocalAnchorA() : joint.GetLocalAnchorB();
  const b2Vec2 on_wheel = wheel_is_b ? joint.GetLocalAnchorB() : joint.GetLocalAnchorA();
  const float yaw = static_cast<float>(body.GetAngle() + angle);
  wheel.SetTransform(body.GetWorldPoint(hub) - b2Mul(b2Rot(yaw), on_wheel), yaw);
  wheel.SetLinearVelocity(body.GetLinearVelocityFromLocalPoint(hub));
  wheel.SetAngularVelocity(body.GetAngularVelocity());
}

}  // namespace flatland
