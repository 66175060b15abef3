#include "box2d_limits.hpp"

#include <algorithm>
#include <stdexcept>

namespace flatland {

void Require(bool condition, const char* message) {
  if (!condition) throw std::invalid_argument(message);
}

void RequirePlace(Vec2 place) {
  Require(std::abs(place.x) <= kFarthest && std::abs(place.y) <= kFarthest,
          "a position must be finite and within 100 km of the origin");
}

void RequireNotNegative(double value, const char* message) {
  Require(IsUsable(value) && value >= 0.0, message);
}

// b2PolygonShape::Set welds vertices closer than half b2_linearSlop and asserts that a hull with
// an area is left. The same test, in the same precision, without the assertion.
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
  // b2_epsilon and something to spare; a sliver's area must also stand out from rounding [m^2].
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

// b2Body::ResetMassData asserts that the moment of inertia about the centre of mass is positive,
// and rounding makes it negative for a small shape far from its body's origin.
bool HasInertia(const b2Body& body, const b2Shape& shape, float density) {
  if (body.GetType() != b2_dynamicBody) return true;
  b2MassData sum;
  shape.ComputeMass(&sum, density);
  b2Vec2 moment = sum.mass * sum.center;
  for (const b2Fixture* f = body.GetFixtureList(); f != nullptr; f = f->GetNext()) {
    if (f->GetDensity() == 0.0f) continue;
    b2MassData part;
    f->GetMassData(&part);
    sum.mass += part.mass;
    sum.I += part.I;
    moment += part.mass * part.center;
  }
  if (sum.mass <= 0.0f || sum.I <= 0.0f) return true;  // Box2D does not get as far as the assertion
  const b2Vec2 center = (1.0f / sum.mass) * moment;
  return sum.I - sum.mass * b2Dot(center, center) > 1e-6f * sum.I;
}

}  // namespace flatland
