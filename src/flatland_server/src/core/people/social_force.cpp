#include "people/social_force.hpp"

#include <algorithm>
#include <cmath>

#include "base/box2d_limits.hpp"
#include "sight/doubles.hpp"

namespace flatland {
namespace {

constexpr double kVelocityWeight = 2.0;  // lambda [s/m]: of the velocity against the direction
constexpr double kReaction = 0.35;       // gamma [m]: range of the evasion, per length of D
constexpr double kFar = 8.0;             // ranges of a force: it is down to e^-8
constexpr double kLeastReach = 1e-9;     // range of the evasion [m]
constexpr double kMargin = 1.0 + 1e-9;   // of comparisons, for rounding
// n and n' [1/m]: narrowness of the range of angles in which the other is evaded.
constexpr double kNarrownessOfTurning = 2.0;
constexpr double kNarrownessOfSlowing = 3.0;

/// exp(-(factor * angle)^2).
double Bell(double factor, double angle) {
  const double deviation = factor * angle;
  return std::exp(-deviation * deviation);
}

/// Writes the result of FindNear to an array that has room for all people and kGroup more. Returns
/// their number. `far` is the gap beyond which there is no repulsion [m].
///
/// With the offset s of length d from the person to another, and the relative velocity w, the D of
/// Evade has
///
///     d |D|^2 = d |lambda w + s / d|^2 = d (lambda^2 w^2 + 1) + 2 lambda w s,
///
/// so that its reach is compared with the gap without a division, and with one root.
FLATLAND_CLONES size_t FindNearIn(const Walkers& people, size_t index, double far, uint32_t* near) {
  constexpr double kReach = kFar * kReaction * kMargin;
  const double x = people.x[index], y = people.y[index], radius = people.radius[index];
  const double vx = people.vx[index], vy = people.vy[index];
  size_t found = 0;
  for (size_t j = index + 1; j < people.count; j += kGroup) {
    const Doubles dx = Load(&people.x[j]) - x, dy = Load(&people.y[j]) - y;
    const Doubles wx = vx - Load(&people.vx[j]), wy = vy - Load(&people.vy[j]);
    const Doubles distance = Sqrt(dx * dx + dy * dy);
    const Doubles gap = distance - radius - Load(&people.radius[j]);
    const Doubles square =
        distance * (kVelocityWeight * kVelocityWeight * (wx * wx + wy * wy) + 1.0) +
        2.0 * kVelocityWeight * (wx * dx + wy * dy);
    const Mask is_far = (gap > far) & (gap * gap * distance > kReach * kReach * square);
    for (int k = 0; k < kGroup; ++k) {
      near[found] = static_cast<uint32_t>(j) + k;
      found += static_cast<size_t>(1 + is_far[k]);  // without a branch, which cannot be predicted
    }
  }
  while (found > 0 && near[found - 1] >= people.count) --found;  // behind the last person
  return found;
}

}  // namespace

void Walkers::Resize(size_t new_count) {
  count = new_count;
  for (std::vector<double>* each : {&x, &y, &vx, &vy, &radius}) each->resize(count + kGroup);
}

void Walkers::Set(size_t index, Vec2 point, Vec2 velocity, double its_radius) {
  x[index] = point.x;
  y[index] = point.y;
  vx[index] = velocity.x;
  vy[index] = velocity.y;
  radius[index] = its_radius;
}

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
  const double reach = std::max(kReaction * length, kLeastReach);
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

void SocialForce::FindNear(const Walkers& people, size_t index, std::vector<uint32_t>& near) const {
  near.resize(people.count + kGroup);
  const double far = kFar * std::max(range, kLeastReach) * kMargin;
  near.resize(FindNearIn(people, index, far, near.data()));
}

double SocialForce::LeftAfter(double dt) const { return std::exp(-dt / relaxation_time); }

Vec2 SocialForce::Relax(Vec2 velocity, Vec2 desired, Vec2 acceleration, double left) const {
  const Vec2 end = desired + relaxation_time * acceleration;
  return end + left * (velocity - end);
}

double SocialForce::ScatterAfter(double dt) const {
  return noise * std::sqrt(1.0 - std::exp(-2.0 * dt / relaxation_time));
}

}  // namespace flatland
