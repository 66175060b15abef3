#include "base/box2d_limits.hpp"

#include <algorithm>
#include <stdexcept>

namespace flatland {

void Refuse(const char* message) { throw std::invalid_argument(message); }

void RequireNotNegative(double value, const char* message) {
  Require(IsUsable(value) && value >= 0.0, message);
}

// b2PolygonShape::Set merges vertices closer than half b2_linearSlop and asserts that a hull with
// an area is left. This is the same test, in the same precision, without the assertion.
bool HasHull(const std::vector<b2Vec2>& vertices) {
  std::vector<b2Vec2> corners;
  float longest_squared = 0.0f;
  for (const b2Vec2& vertex : vertices) {
    bool is_new = true;
    for (const b2Vec2& corner : corners) {
      const float apart_squared = b2DistanceSquared(vertex, corner);
      is_new = is_new && apart_squared >= 0.25f * b2_linearSlop * b2_linearSlop;
      longest_squared = std::max(longest_squared, apart_squared);
    }
    if (is_new) corners.push_back(vertex);
  }
  // [m^2]: above b2_epsilon, and above the rounding error in the area of a long, thin triangle.
  const float least_area = std::max(1e-6f, 1e-5f * longest_squared);
  for (size_t i = 0; i + 2 < corners.size(); ++i) {
    for (size_t j = i + 1; j + 1 < corners.size(); ++j) {
      for (size_t k = j + 1; k < corners.size(); ++k) {
        const b2Vec2 u = corners[j] - corners[i];
        const b2Vec2 v = corners[k] - corners[i];
        if (0.5f * std::abs(b2Cross(u, v)) > least_area) return true;
      }
    }
  }
  return false;
}

}  // namespace flatland
