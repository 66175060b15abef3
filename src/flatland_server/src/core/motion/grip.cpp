#include "motion/grip.hpp"

#include <algorithm>
#include <cmath>

#include "base/box2d_internals.hpp"

namespace flatland {
namespace {

constexpr double kStandardGravity = 9.80665;  // [m/s^2]
constexpr double kMost = 1e9;                 // see IsUsable

/// Moment of inertia about the centre of mass [kg m^2].
float CentralInertia(const b2Body& body) {
  return body.GetInertia() - body.GetMass() * body.GetLocalCenter().LengthSquared();
}

/// Gives the body the impulse by which Box2D's friction joint would pull it to a velocity in a step
/// of `dt` [s], within a force [N] and a torque [N m]. As the solver does, it counts forces of
/// others and damping first (b2Island::Solve).
void PullFreely(b2Body& body, b2Vec2 velocity, float omega, float force, float torque, float dt) {
  const float inverse_mass = 1.0f / body.GetMass();
  const float inverse_inertia = 1.0f / CentralInertia(body);
  const float damping = 1.0f + dt * body.GetLinearDamping();
  const float turn_damping = 1.0f + dt * body.GetAngularDamping();
  const b2Vec2 own = body.GetLinearVelocity();
  const float own_omega = body.GetAngularVelocity();
  b2Vec2 change = velocity - 1.0f / damping * (own + dt * inverse_mass * box2d::Force(body));
  const float most = dt * force * inverse_mass, squared = change.LengthSquared();
  if (squared > most * most) change *= most / std::sqrt(squared);
  const float most_turn = dt * torque * inverse_inertia;
  const float turn =
      b2Clamp(omega - (own_omega + dt * inverse_inertia * box2d::Torque(body)) / turn_damping,
              -most_turn, most_turn);
  body.SetLinearVelocity(own + damping * change);
  body.SetAngularVelocity(own_omega + turn_damping * turn);
}

}  // namespace

void Grip::Begin(b2Body& body, double mass_on_wheels, b2Vec2 velocity, float omega, double dt) {
  const double own = body.GetMass();
  const double radius = std::sqrt(CentralInertia(body) / own);
  const auto [max_force, max_torque, friction] = limits_;
  double force = max_force, torque = max_torque;
  if (force == 0.0) force = torque > 0.0 && friction == 0.0 ? torque / radius : kMost;
  if (torque == 0.0) torque = force * radius;
  slips_ = spins_ = false;
  if (friction > 0.0) {
    const double most = friction * mass_on_wheels * kStandardGravity;
    slips_ = most <= force;
    spins_ = most * radius <= torque;
    force = std::min(force, most);
    torque = std::min(torque, most * radius);
  }
  const auto most_force = static_cast<float>(std::min(force, kMost));
  const auto most_torque = static_cast<float>(std::min(torque, kMost));
  // The joint's anchor is where the centre of mass was when it was made.
  const bool is_free = body.GetContactList() == nullptr && body.GetJointList()->next == nullptr &&
                       joint_->GetLocalAnchorB() == body.GetLocalCenter();
  belt()->SetEnabled(!is_free);  // the solver skips the joint of a body that is not enabled
  if (is_free) {
    return PullFreely(body, velocity, omega, most_force, most_torque, static_cast<float>(dt));
  }
  joint_->SetMaxForce(most_force);
  joint_->SetMaxTorque(most_torque);
  const b2Vec2 arm = joint_->GetAnchorB() - body.GetWorldCenter();
  belt()->SetLinearVelocity(velocity + b2Cross(omega, arm));
  belt()->SetAngularVelocity(omega);
}

void Grip::End() {
  if (belt()->IsEnabled()) belt()->SetTransform(b2Vec2_zero, 0.0f);
}

}  // namespace flatland
