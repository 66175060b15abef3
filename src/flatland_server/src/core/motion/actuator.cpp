#include "motion/actuator.hpp"

#include <algorithm>
#include <cmath>

#include "base/box2d_limits.hpp"

namespace flatland {
namespace {

/// The longest delay [s]; the line keeps all commands of this time.
constexpr double kMaxDelay = 10.0;
/// A lag has ended when its output is this near to its input [m/s, rad/s or rad].
constexpr double kSettled = 1e-9;

uint64_t Nanoseconds(double seconds) {
  return static_cast<uint64_t>(std::nearbyint(std::min(seconds, 1e9) * 1e9));
}

}  // namespace

void ActuatorSettings::Check() const {
  RequireNotNegative(command_timeout, "command_timeout must be finite and not negative");
  for (const double each : {force.max_force, force.max_torque, force.friction}) {
    RequireNotNegative(each, "a limit of a drive's force must be finite and not negative");
  }
  for (const AxisSettings& axis : {linear, angular}) {
    for (const double each : {axis.delay, axis.time_constant, axis.dead_band, axis.noise}) {
      RequireNotNegative(each, "a number of an actuator must be finite and not negative");
    }
    Require(axis.delay <= kMaxDelay, "a delay must be 10 s at most");
  }
}

Vec2 DelayLine::Pass(Vec2 value, uint64_t now, uint64_t delay) {
  if (delay == 0) return value;
  if (value.x != last_in_.x || value.y != last_in_.y) under_way_.push_back({now, value});
  last_in_ = value;
  const auto arrived = std::find_if(under_way_.begin(), under_way_.end(),
                                    [&](const Entry& each) { return each.time + delay > now; });
  if (arrived != under_way_.begin()) {
    out_ = (arrived - 1)->value;
    under_way_.erase(under_way_.begin(), arrived);
  }
  return out_;
}

void DelayLine::Reset(Vec2 value) {
  under_way_.clear();
  last_in_ = out_ = value;
}

// The input is the straight line with the given mean and end: u(t) = u1 + b (t - dt). Then
// y = u - T b + (y0 - u0 + T b) exp(-t / T), and the mean follows from T y' = u - y.
VelocityChange Lag(Vec2 from, const VelocityChange& input, double time_constant, double dt) {
  if (time_constant == 0.0) return input;
  const double ratio = time_constant / dt;
  const Vec2 lagging = 2.0 * ratio * (input.reached - input.mean);  // T b
  const Vec2 start = 2.0 * input.mean - input.reached;
  const Vec2 way = from - start + lagging;
  Vec2 reached = input.reached - lagging + std::exp(-1.0 / ratio) * way;
  const Vec2 left = reached - input.reached;
  if (std::abs(left.x) < kSettled && std::abs(left.y) < kSettled) reached = input.reached;
  return {reached, input.mean - ratio * (reached - from)};
}

Actuator::Actuator(const ActuatorSettings& settings, bool is_steered)
    : settings_(settings), is_steered_(is_steered) {
  settings.Check();
  Seed(settings.key);
}

Twist Actuator::Arrive(Twist target, double dt) {
  const uint64_t now = state_.now;
  state_.now += Nanoseconds(dt);
  state_.rolling = {};
  const double timeout = settings_.command_timeout;
  if (timeout > 0.0 && now - state_.commanded >= std::max<uint64_t>(Nanoseconds(timeout), 1)) {
    target = {0.0, 0.0, is_steered_ ? target.omega : 0.0};
  }
  const AxisSettings &linear = settings_.linear, &angular = settings_.angular;
  if (std::hypot(target.vx, target.vy) < linear.dead_band) target.vx = target.vy = 0.0;
  const double turned = is_steered_ ? target.omega - state_.held : target.omega;
  if (std::abs(turned) < angular.dead_band) target.omega = is_steered_ ? state_.held : 0.0;
  state_.held = target.omega;
  const Vec2 planar = linear_line_.Pass({target.vx, target.vy}, now, Nanoseconds(linear.delay));
  const Vec2 turning = angular_line_.Pass({target.omega, 0.0}, now, Nanoseconds(angular.delay));
  return {planar.x, planar.y, turning.x};
}

double Actuator::Noise(const AxisSettings& axis, double dt) {
  return axis.noise > 0.0 ? std::sqrt(axis.noise / dt) * state_.numbers.Draw() : 0.0;
}

void Actuator::Follow(VelocityChange& linear, VelocityChange& angular, double dt) {
  const double speed = std::hypot(linear.mean.x, linear.mean.y);
  if (speed > 0.0) {
    const Vec2 noise = Noise(settings_.linear, dt) / speed * linear.mean;
    linear = {linear.reached + noise, linear.mean + noise};
  }
  if (!is_steered_ && (speed > 0.0 || angular.mean.x != 0.0)) {
    const Vec2 noise{Noise(settings_.angular, dt), 0.0};
    angular = {angular.reached + noise, angular.mean + noise};
  }
  Twist& velocity = state_.velocity;
  linear = Lag({velocity.vx, velocity.vy}, linear, settings_.linear.time_constant, dt);
  if (!is_steered_) {
    angular = Lag({velocity.omega, 0.0}, angular, settings_.angular.time_constant, dt);
    velocity.omega = angular.reached.x;
  }
  velocity.vx = linear.reached.x;
  velocity.vy = linear.reached.y;
}

double Actuator::Steer(double mean, double reached, double time) {
  double& angle = state_.velocity.omega;
  const VelocityChange input{{reached, 0.0}, {mean, 0.0}};
  angle = Lag({angle, 0.0}, input, settings_.angular.time_constant, time).reached.x;
  return angle;
}

double Steer(SteeringState& steering, double target, const DynamicsLimits& limits,
             OptionalActuator& actuator, double dt) {
  const auto steered_for = [&, from = steering](double time) {
    return Steer(from, target, limits, time);
  };
  const double halfway = steered_for(0.5 * dt).angle;
  steering = steered_for(dt);
  if (!actuator) return halfway;
  const double first = actuator->Steer(steered_for(0.25 * dt).angle, halfway, 0.5 * dt);
  actuator->Steer(steered_for(0.75 * dt).angle, steering.angle, 0.5 * dt);
  return first;
}

Pose Actuator::Measured(const Pose& arc, double dt) const {
  const auto& [vx, vy, omega] = state_.rolling;
  Pose measured = arc;
  if (grip_.slips()) measured.x = vx * dt;
  if (grip_.slips()) measured.y = vy * dt;
  if (grip_.spins()) measured.yaw = omega * dt;
  return measured;
}

void Actuator::Reset() {
  const double angle = is_steered_ ? state_.velocity.omega : 0.0;
  state_.velocity = {0.0, 0.0, angle};
  state_.held = angle;
  linear_line_.Reset({});
  angular_line_.Reset({angle, 0.0});
}

}  // namespace flatland
