#include "motion/steering.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace flatland {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

/// A limit of 0 means no limit.
double OrInfinity(double limit) { return limit > 0.0 ? limit : kInfinity; }

/// Changes the rate to `end_rate` at a constant acceleration, as far as `time` allows, and
/// subtracts the time it takes. Returns whether it was completed. An infinite acceleration takes no
/// time.
bool Ramp(SteeringState& state, double end_rate, double acceleration, double& time) {
  const double change = end_rate - state.rate;
  const double duration = std::abs(change) / acceleration;
  const double spent = std::min(time, duration);
  const double reached =
      spent < duration ? state.rate + std::copysign(acceleration, change) * spent : end_rate;
  state.angle += 0.5 * (state.rate + reached) * spent;
  state.rate = reached;
  time -= spent;
  return spent == duration;
}

}  // namespace

SteeringState Steer(SteeringState from, double target, const DynamicsLimits& limits, double time) {
  const double speed_up = OrInfinity(limits.acceleration);
  const double slow_down = OrInfinity(limits.deceleration);
  const double fastest = OrInfinity(limits.velocity);

  SteeringState state = from;
  const double way = target - state.angle;
  const double stopping_way = 0.5 * state.rate * state.rate / slow_down;
  const bool goes_away = state.rate * way <= 0.0;  // or is at the target
  const bool overshoots = stopping_way > std::abs(way) * (1.0 + 1e-9) + 1e-12;
  if (goes_away || overshoots) {
    if (!Ramp(state, 0.0, slow_down, time)) return state;
  }

  const double side = target < state.angle ? -1.0 : 1.0;
  const double distance = std::abs(target - state.angle);
  const double rate = std::abs(state.rate);
  if (distance == 0.0 && rate == 0.0) return state;
  // The rate rises from `rate` to the peak and falls to 0; the area under it is the distance:
  // (peak^2 - rate^2) / (2 speed_up) + peak^2 / (2 slow_down) = distance.
  const double peak_squared =
      (2.0 * distance + rate * rate / speed_up) / (1.0 / speed_up + 1.0 / slow_down);
  const double peak = std::max(rate, std::min(fastest, std::sqrt(peak_squared)));
  if (std::isinf(peak)) return {target, 0.0};
  if (!Ramp(state, side * peak, speed_up, time)) return state;
  const double braking_way = 0.5 * peak * peak / slow_down;
  const double cruise = std::max(0.0, std::abs(target - state.angle) - braking_way) / peak;
  const double cruised = std::min(time, cruise);
  state.angle += state.rate * cruised;
  time -= cruised;
  if (cruised < cruise || !Ramp(state, 0.0, slow_down, time)) return state;
  return {target, 0.0};
}

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
