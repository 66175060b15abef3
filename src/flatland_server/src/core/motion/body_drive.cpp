#include "motion/body_drive.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace flatland {
namespace {

bool IsZero(const Twist& twist) { return twist.vx == 0.0 && twist.vy == 0.0 && twist.omega == 0.0; }

}  // namespace

BodyDrive::BodyDrive(const DynamicsLimits& linear, const DynamicsLimits& angular,
                     const std::optional<ActuatorSettings>& actuator)
    : ActuatedDrive(actuator, false), linear_(linear), angular_(angular) {
  linear.Check();
  angular.Check();
}

void BodyDrive::Command(const Twist& target) {
  if (!IsUsable(target)) throw std::invalid_argument("a commanded velocity must be finite");
  target_ = target;
  if (actuator_) actuator_->Command();
}

Fastest BodyDrive::GetFastest() const {
  const auto square = [](const Twist& twist) { return twist.vx * twist.vx + twist.vy * twist.vy; };
  const double limit = linear_.velocity, target = square(target_);
  const Twist& present = velocity();
  return {std::max(square(present), limit > 0.0 ? std::min(target, limit * limit) : target),
          std::max(std::abs(present.omega), angular_.Limited(std::abs(target_.omega)))};
}

void BodyDrive::Reset() {
  target_ = {};
  velocity_ = {};
  Stop();
}

void BodyDrive::BeginStep(b2Body& body, double dt) {
  const Twist target = actuator_ ? actuator_->Arrive(target_, dt) : target_;
  is_idle_ = !body.IsAwake() && actuator_.grip() == nullptr && IsZero(target) &&
             IsZero(velocity_) && IsZero(velocity());
  if (is_idle_) return;
  VelocityChange planar =
      linear_.Approach({velocity_.vx, velocity_.vy}, {target.vx, target.vy}, dt);
  VelocityChange rotating = angular_.Approach({velocity_.omega, 0.0}, {target.omega, 0.0}, dt);
  velocity_ = {planar.reached.x, planar.reached.y, rotating.reached.x};
  if (actuator_) actuator_->Follow(planar, rotating, dt);
  const Twist mean{planar.mean.x, planar.mean.y, rotating.mean.x};
  Begin(body, mean, dt);
}

void BodyDrive::EndStep(b2Body& body) {
  if (!is_idle_) motion_.End(body, velocity(), actuator_.grip());
}

}  // namespace flatland
