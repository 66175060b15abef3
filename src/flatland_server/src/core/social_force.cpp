#include "flatland_server/social_force.hpp"

#include <algorithm>
#include <cmath>

#include "box2d_limits.hpp"

namespace flatland {
namespace {

constexpr double kVelocityWeight = 2.0;  // lambda [s/m]: of the velocity against the direction
constexpr double kReaction = 0.35;       // gamma [m]: range of the evasion, per length of D
constexpr double kFar = 8.0;             // ranges of a force: it is down to e^-8
// n and n' [1/m]: narrowness of the range of angles in which the other is evaded.
constexpr double kNarrownessOfTurning = 2.0;
constexpr double kNarrownessOfSlowing = 3.0;

/// exp(-(factor * angle)^2).
double Bell(double factor, double angle) {
  const double deviation = factor * angle;
  return std::exp(-deviation * deviation);
}

}  // namespace

void SocialForce::Require() const {
  flatland::Require(IsUsable(relaxation_time) && relaxation_time > 0.0,
                    "a relaxation time must be above zero");
  flatland::Require(IsUsable(range) && range > 0.0, "a range must be above zero");
  flatland::Require(IsUsable(side_preference), "a preference must be finite");
  for (const double each : {repulsion, evasion, noise}) {
    RequireNotNegative(each, "a force must be finite and not negative");
  }
}

Vec2 SocialForce::Repel(const Obstacle& obstacle) const {
  if (obstacle.gap > kFar * range) return {};
  return repulsion * std::exp(-std::max(obstacle.gap, 0.0) / range) * obstacle.away;
}

Vec2 SocialForce::Evade(const Obstacle& other, Vec2 velocity) const {
  const Vec2 towards = -1.0 * other.away;
  const Vec2 interaction = kVelocityWeight * velocity + towards;
  const double length = LengthOf(interaction);
  if (length == 0.0) return {};
  const double reach = std::max(kReaction * length, 1e-9);
  if (other.gap > kFar * reach) return {};
  const double strength = evasion * std::exp(-std::max(other.gap, 0.0) / reach);
  const Vec2 course = (1.0 / length) * interaction;
  const Vec2 left{-course.y, course.x};
  const double angle =
      std::atan2(Dot(left, towards), Dot(course, towards)) + side_preference * reach;
  const double slow_down = strength * Bell(kNarrownessOfSlowing * reach, angle);
  double turn = strength * Bell(kNarrownessOfTurning * reach, angle);
  if (angle <= 0.0) turn = angle < 0.0 ? -turn : 0.0;
  return -slow_down * course - turn * left;
}

Vec2 SocialForce::Relax(Vec2 velocity, Vec2 desired, Vec2 acceleration, double dt) const {
  const Vec2 end = desired + relaxation_time * acceleration;
  return end + std::exp(-dt / relaxation_time) * (velocity - end);
}

double SocialForce::ScatterAfter(double dt) const {
  return noise * std::sqrt(1.0 - std::exp(-2.0 * dt / relaxation_time));
}

}  // namespace flatland
