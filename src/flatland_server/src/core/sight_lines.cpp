#include "sight_lines.hpp"

#include <algorithm>

namespace flatland {
namespace {

/// Begins with a line across `normal`, and turns it until it touches both.
Shaft::Side SideOf(const SightLines& lines, Vec2 normal) {
  const auto farthest_corner = [&] {
    return *std::max_element(lines.corners.begin(), lines.corners.end(),
                             [&](Vec2 a, Vec2 b) { return Dot(normal, a) < Dot(normal, b); });
  };
  const auto farther_end = [&] {
    return Dot(normal, lines.to.b) > Dot(normal, lines.to.a) ? lines.to.b : lines.to.a;
  };
  Vec2 one = farthest_corner(), other = farther_end();
  for (int turns = 0; turns < 2; ++turns) {
    const Vec2 way = other - one, across{-way.y, way.x};
    const double sign = Dot(across, normal);
    if (sign == 0.0) break;
    normal = sign > 0.0 ? across : -1.0 * across;
    one = farthest_corner();
    other = farther_end();
  }
  return {normal, std::max(Dot(normal, one), Dot(normal, other))};
}

}  // namespace

std::array<SightLines, 2> SightLines::Halves() const {
  const Vec2 size = from.high - from.low, target_size = bounds.high - bounds.low;
  if (std::max(size.x, size.y) > std::max(target_size.x, target_size.y)) {
    Box low = from, high = from;
    const Vec2 middle = Middle(from);
    if (size.x > size.y) {
      low.high.x = high.low.x = middle.x;
    } else {
      low.high.y = high.low.y = middle.y;
    }
    return {SightLines(low, to), SightLines(high, to)};
  }
  const Vec2 middle = Middle(to);
  return {SightLines(from, {to.a, middle}), SightLines(from, {middle, to.b})};
}

Shaft::Shaft(const SightLines& lines) : bounds(lines.from) {
  bounds.Add(lines.bounds);
  const Vec2 way = Middle(lines.to) - Middle(lines.from);
  sides = {SideOf(lines, {-way.y, way.x}), SideOf(lines, {way.y, -way.x})};
}

}  // namespace flatland
