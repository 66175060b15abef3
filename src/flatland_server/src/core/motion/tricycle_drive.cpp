#include "motion/tricycle_drive.hpp"

#include <algorithm>

#include "base/box2d_limits.hpp"

namespace flatland {

TricycleDrive::TricycleDrive(const TricycleSettings& settings, b2RevoluteJoint* front_wheel)
    : ActuatedDrive(settings.actuator, true), settings_(settings), front_wheel_(front_wheel) {
  settings.linear.Check();
  settings.steering.Check();
  RequirePosition(settings.rear_axle);
  RequireNotNegative(settings.max_steer_angle, "max_steer_angle must be finite and not negative");
  wheelbase_ = std::hypot(settings.rear_axle.x, settings.rear_axle.y);
  Require(wheelbase_ >= 1e-3, "the rear axle must be apart from the front wheel");
  heading_ = std::atan2(-settings.rear_axle.y, -settings.rear_axle.x);
}

void TricycleDrive::Command(double speed, double angle) {
  Require(IsUsable(speed) && IsUsable(angle),
          "a commanded speed and steering angle must be finite");
  const double most = settings_.max_steer_angle;
  target_speed_ = speed;
  target_angle_ = most > 0.0 ? std::clamp(angle, -most, most) : angle;
  if (actuator_) actuator_->Command();
}

Fastest TricycleDrive::GetFastest() const {
  const double speed =
      std::max(std::abs(this->speed()), settings_.linear.Limited(std::abs(target_speed_)));
  const double angle = std::max(std::abs(steer_angle()), std::abs(target_angle_));
  return {speed * speed, speed * std::min(angle, 1.0) / wheelbase_};
}

void TricycleDrive::Reset() {
  target_speed_ = speed_ = 0.0;
  target_angle_ = steering_.angle = steer_angle();
  steering_.rate = 0.0;
  Stop();
}

// The rear axle does not slip sideways: with the front wheel rolling at v and angle d, and the
// wheelbase L, v sin d - omega L = 0 (Siciliano et al., "Robotics", 11.2.2, front-wheel drive).
Twist TricycleDrive::TwistAt(double speed, double angle) {
  if (angle != direction_.angle) {
    direction_ = {angle, Rotation(heading_ + angle), std::sin(angle)};
  }
  const Vec2 velocity = direction_.rotation.Apply({speed, 0.0});
  return {velocity.x, velocity.y, speed * direction_.sin / wheelbase_};
}

void TricycleDrive::BeginStep(b2Body& body, double dt) {
  Twist target{target_speed_, 0.0, target_angle_};
  if (actuator_) target = actuator_->Arrive(target, dt);
  VelocityChange rolling = settings_.linear.Approach({speed_, 0.0}, {target.vx, 0.0}, dt);
  const double halfway = Steer(steering_, target.omega, settings_.steering, actuator_, dt);
  speed_ = rolling.reached.x;
  if (actuator_) {
    VelocityChange none;
    actuator_->Follow(rolling, none, dt);
  }
  const Twist mean = TwistAt(rolling.mean.x, halfway);
  Begin(body, mean, dt);
}

void TricycleDrive::EndStep(b2Body& body) {
  motion_.End(body, TwistAt(speed(), steer_angle()), actuator_.grip());
  if (front_wheel_ == nullptr) return;
  PlaceSteeredWheel(*front_wheel_, body, heading_ + steer_angle());
}

}  // namespace flatland
