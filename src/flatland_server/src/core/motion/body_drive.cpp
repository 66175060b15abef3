#include "motion/body_drive.hpp"

#include <stdexcept>

namespace flatland {
namespace {

bool IsZero(const Twist& twist) { return twist.vx == 0.0 && twist.vy == 0.0 && twist.omega == 0.0; }

}  // namespace

BodyDrive::BodyDrive(const DynamicsLimits& linear, const DynamicsLimits& angular)
    : linear_(linear), angular_(angular) {
  linear.Check();
  angular.Check();
}

void BodyDrive::Command(const Twist& target) {
  if (!IsUsable(target)) throw std::invalid_argument("a commanded velocity must be finite");
  target_ = target;
}

void BodyDrive::Reset() {
  target_ = {};
  velocity_ = {};
}

void BodyDrive::BeginStep(b2Body& body, double dt) {
  is_idle_ = !body.IsAwake() && IsZero(target_) && IsZero(velocity_);
  if (is_idle_) return;
  const VelocityChange planar =
      linear_.Approach({velocity_.vx, velocity_.vy}, {target_.vx, target_.vy}, dt);
  const VelocityChange rotating =
      angular_.Approach({velocity_.omega, 0.0}, {target_.omega, 0.0}, dt);
  velocity_ = {planar.reached.x, planar.reached.y, rotating.reached.x};
  motion_.Begin(body, {planar.mean.x, planar.mean.y, rotating.mean.x}, dt);
}

void BodyDrive::EndStep(b2Body& body) {
  if (!is_idle_) motion_.End(body, velocity_);
}

}  // namespace flatland
