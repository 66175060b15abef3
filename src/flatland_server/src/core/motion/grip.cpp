#include "motion/grip.hpp"

#include <algorithm>
#include <cmath>

namespace flatland {
namespace {

constexpr double kGravity = 9.80665;  // standard [m/s^2]
constexpr double kMost = 1e9;         // see IsUsable

}  // namespace

void Grip::Begin(const b2Body& body, double mass_on_wheels) {
  const double own = body.GetMass();
  const double inertia = body.GetInertia() - own * body.GetLocalCenter().LengthSquared();
  const double radius = std::sqrt(inertia / own);
  const auto [max_force, max_torque, friction] = limits_;
  double force = max_force, torque = max_torque;
  if (force == 0.0) force = torque > 0.0 && friction == 0.0 ? torque / radius : kMost;
  if (torque == 0.0) torque = force * radius;
  slips_ = spins_ = false;
  if (friction > 0.0) {
    const double most = friction * mass_on_wheels * kGravity;
    slips_ = most <= force;
    spins_ = most * radius <= torque;
    force = std::min(force, most);
    torque = std::min(torque, most * radius);
  }
  joint_->SetMaxForce(static_cast<float>(std::min(force, kMost)));
  joint_->SetMaxTorque(static_cast<float>(std::min(torque, kMost)));
}

}  // namespace flatland
