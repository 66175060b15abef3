#include "flatland_server/body_drive.hpp"

#include <algorithm>
#include <stdexcept>

namespace flatland {
namespace {

void Check(const DynamicsLimits& limits) {
  for (double limit : {limits.acceleration, limits.deceleration, limits.velocity}) {
    if (!IsUsable(limit) || limit < 0.0) {
      throw std::invalid_argument("a dynamics limit must be finite and not negative");
    }
  }
}

/// `from` moved towards `to` by at most `rate` * dt; at once if the rate is 0, for no limit.
double MoveTowards(double from, double to, double rate, double dt) {
  if (rate == 0.0) return to;
  const double most = rate * dt;
  return from + std::clamp(to - from, -most, most);
}

}  // namespace

double DynamicsLimits::Approach(double current, double target, double dt) const {
  if (velocity > 0.0) target = std::clamp(target, -velocity, velocity);
  const bool turns_round = current * target < 0.0;
  if (!turns_round) {
    const bool away_from_zero = std::abs(target) > std::abs(current);
    return MoveTowards(current, target, away_from_zero ? acceleration : deceleration, dt);
  }
  const double time_to_zero = deceleration > 0.0 ? std::abs(current) / deceleration : 0.0;
  if (time_to_zero >= dt) return MoveTowards(current, 0.0, deceleration, dt);
  return MoveTowards(0.0, target, acceleration, dt - time_to_zero);
}

BodyDrive::BodyDrive(const DynamicsLimits& linear, const DynamicsLimits& angular)
    : linear_(linear), angular_(angular) {
  Check(linear);
  Check(angular);
}

void BodyDrive::Command(const Twist& target) {
  if (!IsUsable(target)) throw std::invalid_argument("a commanded velocity must be finite");
  target_ = target;
}

void BodyDrive::Reset() {
  target_ = {};
  velocity_ = {};
}

// With a constant twist (vx, vy, omega) in its own frame, in dt a frame moves by the exponential
// map of SE(2): by V (vx, vy) dt in its frame at the start, V = [[s, -c], [c, s]] with s = sin(a) /
// a, c = (1 - cos(a)) / a, a = omega dt (Lynch and Park, "Modern Robotics", 3.3.3). Box2D moves the
// centre of mass along a straight line in a step, so it is given the chord.
void BodyDrive::Apply(b2Body& body, double dt) {
  velocity_ = {linear_.Approach(velocity_.vx, target_.vx, dt),
               linear_.Approach(velocity_.vy, target_.vy, dt),
               angular_.Approach(velocity_.omega, target_.omega, dt)};

  const double angle = velocity_.omega * dt;
  const bool straight = std::abs(angle) < 1e-6;
  const double s = straight ? 1.0 : std::sin(angle) / angle;
  const double c = straight ? 0.5 * angle : (1.0 - std::cos(angle)) / angle;
  const Vec2 origin_moves{(s * velocity_.vx - c * velocity_.vy) * dt,
                          (c * velocity_.vx + s * velocity_.vy) * dt};
  const b2Vec2 center = body.GetLocalCenter();
  const Vec2 arm{center.x, center.y};
  const Vec2 center_moves = origin_moves + Rotation(angle).Apply(arm) - arm;
  const Vec2 moves = Rotation(body.GetAngle()).Apply(center_moves);
  body.SetLinearVelocity({static_cast<float>(moves.x / dt), static_cast<float>(moves.y / dt)});
  body.SetAngularVelocity(static_cast<float>(velocity_.omega));
}

}  // namespace flatland
