#include "motion/dynamics_limits.hpp"

#include <algorithm>
#include <limits>
#include <stdexcept>

namespace flatland {

void DynamicsLimits::Check() const {
  for (double limit : {acceleration, deceleration, velocity}) {
    if (!IsUsable(limit) || limit < 0.0) {
      throw std::invalid_argument("a dynamics limit must be finite and not negative");
    }
  }
}

// On the line from `current` to `target`, of length L, the speed falls up to the point nearest to
// zero and rises after it. So the position on the line, as a function of time, has a slope of
// `deceleration` in the first part, of `acceleration` in the second, and is constant after that.
// The mean velocity is the integral of these three pieces.
VelocityChange DynamicsLimits::Approach(Vec2 current, Vec2 target, double dt) const {
  if (velocity > 0.0) {
    const double speed = std::hypot(target.x, target.y);
    if (speed > velocity) target = velocity / speed * target;
  }
  const Vec2 way = target - current;
  if (way.x == 0.0 && way.y == 0.0) return {target, target};  // as in most steps
  const double length = std::hypot(way.x, way.y);
  // A length near the smallest number has no finite inverse.
  if (length < std::numeric_limits<double>::min()) return {target, target};
  const Vec2 along = 1.0 / length * way;
  const double falling = std::clamp(-Dot(current, along), 0.0, length);
  const double rising = length - falling;

  const double fall_time = deceleration > 0.0 ? falling / deceleration : 0.0;
  const double rise_time = acceleration > 0.0 ? rising / acceleration : 0.0;
  const double falls = std::min(dt, fall_time);
  const double rises = std::clamp(dt - fall_time, 0.0, rise_time);
  const double rests = std::max(0.0, dt - fall_time - rise_time);
  const double integral = 0.5 * deceleration * falls * falls +
                          (falling + 0.5 * acceleration * rises) * rises + length * rests;
  if (rests > 0.0) return {target, current + integral / dt * along};
  const double reached = dt < fall_time ? deceleration * falls : falling + acceleration * rises;
  return {current + reached * along, current + integral / dt * along};
}

}  // namespace flatland
