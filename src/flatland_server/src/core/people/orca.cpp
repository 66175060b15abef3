#include "people/orca.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

#include "base/box2d_limits.hpp"

namespace flatland {
namespace {

constexpr double kParallel = 1e-5;  // the sine of the angle between lines that count as parallel

/// Distance [m/s] of a velocity from a half plane; negative within it.
double DistanceFrom(const HalfPlane& plane, Vec2 velocity) {
  return Cross(plane.direction, plane.point - velocity);
}

/// An objective for the velocity, which may have a length of `most` [m/s].
struct Aim {
  Vec2 optimum;      // the nearest to this one; or
  bool is_farthest;  // the farthest in this direction, of length 1
  double most;

  Vec2 Unrestricted() const {
    if (is_farthest) return most * optimum;
    const double length = LengthOf(optimum);
    return length > most ? (most / length) * optimum : optimum;
  }
};

/// The best velocity on the line of a half plane, of those that are in all half planes before it.
std::optional<Vec2> BestOnLine(const std::vector<HalfPlane>& planes, size_t index, const Aim& aim) {
  const auto& [point, direction] = planes[index];
  const double middle = -Dot(point, direction);
  const double square = middle * middle + aim.most * aim.most - Dot(point, point);
  if (square < 0.0) return std::nullopt;
  double low = middle - std::sqrt(square), high = middle + std::sqrt(square);
  for (size_t i = 0; i < index; ++i) {
    const double sine = Cross(direction, planes[i].direction);
    const double outside = Cross(planes[i].direction, point - planes[i].point);
    if (std::abs(sine) <= kParallel) {
      if (outside < 0.0) return std::nullopt;
      continue;
    }
    (sine > 0.0 ? high : low) =
        sine > 0.0 ? std::min(high, outside / sine) : std::max(low, outside / sine);
    if (low > high) return std::nullopt;
  }
  const double wish = Dot(direction, aim.is_farthest ? aim.optimum : aim.optimum - point);
  const double at = !aim.is_farthest ? std::clamp(wish, low, high) : wish > 0.0 ? high : low;
  return point + at * direction;
}

/// Finds the best velocity in the half planes before the first one that leaves none, and returns
/// their number. Half planes are added one by one: if the best velocity so far is not in the next
/// one, the new best is on the line of that half plane.
size_t FindBest(const std::vector<HalfPlane>& planes, const Aim& aim, Vec2& best) {
  best = aim.Unrestricted();
  for (size_t i = 0; i < planes.size(); ++i) {
    if (DistanceFrom(planes[i], best) <= 0.0) continue;
    const std::optional<Vec2> on_line = BestOnLine(planes, i, aim);
    if (!on_line) return i;
    best = *on_line;
  }
  return planes.size();
}

/// The velocities that are at least as near to the second half plane as to the first. They are a
/// half plane; none if both have the same direction.
std::optional<HalfPlane> NearerTo(const HalfPlane& second, const HalfPlane& first) {
  const double sine = Cross(first.direction, second.direction);
  Vec2 point;
  if (std::abs(sine) > kParallel) {
    const double at = Cross(second.direction, first.point - second.point) / sine;
    point = first.point + at * first.direction;
  } else if (Dot(first.direction, second.direction) > 0.0) {
    return std::nullopt;
  } else {
    point = 0.5 * (first.point + second.point);
  }
  const Vec2 between = second.direction - first.direction;
  return HalfPlane{point, (1.0 / LengthOf(between)) * between};
}

}  // namespace

void OrcaSettings::Require() const {
  for (const double each : {horizon, wall_horizon, distance}) {
    flatland::Require(IsUsable(each) && each > 0.0, "times and distances must be above zero");
  }
  flatland::Require(neighbors > 0, "the number of neighbours must be above zero");
}

HalfPlane AvoidNeighbor(const OrcaNeighbor& other, Vec2 velocity, double horizon, double dt) {
  const Vec2 offset = other.offset;
  const Vec2 relative = velocity - other.velocity;
  const double radius = other.radius;
  const double square = Dot(offset, offset);
  const bool is_apart = square > radius * radius;
  const double time = is_apart ? horizon : dt;
  // The cone is cut off by a circle about `offset / time`.
  const Vec2 from_circle = relative - (1.0 / time) * offset;
  const double ahead = Dot(from_circle, offset);
  const double length = LengthOf(from_circle);
  Vec2 direction, change;
  if (!is_apart || (ahead < 0.0 && ahead * ahead > radius * radius * length * length)) {
    const Vec2 out = length > 0.0 ? (1.0 / length) * from_circle : Vec2{1.0, 0.0};
    direction = {out.y, -out.x};
    change = (radius / time - length) * out;
  } else {
    const double side = Cross(offset, from_circle) > 0.0 ? 1.0 : -1.0;
    const double leg = side * std::sqrt(square - radius * radius);
    direction = (1.0 / square) *
                Vec2{offset.x * leg - offset.y * radius, offset.x * radius + offset.y * leg};
    change = Dot(relative, direction) * direction - relative;
  }
  return {velocity + other.share * change, direction};
}

HalfPlane AvoidWall(const Obstacle& wall, double horizon) {
  return {(-wall.gap / horizon) * wall.away, {wall.away.y, -wall.away.x}};
}

Vec2 ChooseVelocity(const std::vector<HalfPlane>& planes, size_t walls, Vec2 preferred,
                    double most) {
  Vec2 best;
  const size_t kept = FindBest(planes, {preferred, false, most}, best);
  if (kept == planes.size()) return best;
  double farthest = 0.0;
  std::vector<HalfPlane> nearer;
  for (size_t i = kept; i < planes.size(); ++i) {
    if (DistanceFrom(planes[i], best) <= farthest) continue;
    nearer.assign(planes.begin(), planes.begin() + static_cast<std::ptrdiff_t>(walls));
    for (size_t j = walls; j < i; ++j) {
      if (const auto plane = NearerTo(planes[j], planes[i])) nearer.push_back(*plane);
    }
    const Vec2 into{-planes[i].direction.y, planes[i].direction.x};
    Vec2 found;
    if (FindBest(nearer, {into, true, most}, found) == nearer.size()) best = found;
    farthest = DistanceFrom(planes[i], best);
  }
  return best;
}

}  // namespace flatland
