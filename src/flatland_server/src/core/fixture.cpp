#include "flatland_server/fixture.hpp"

#include <utility>

#include "box2d_limits.hpp"
#include "to_box2d.hpp"

namespace flatland {

b2CircleShape MakeCircle(Vec2 center, double radius) {
  RequirePosition(center);
  Require(radius >= kMinRadius && radius <= kMaxCoordinate, "a radius must be 0.1 mm to 100 km");
  b2CircleShape shape;
  shape.m_p = ToBox2D(center);
  shape.m_radius = static_cast<float>(radius);
  return shape;
}

b2PolygonShape MakePolygon(const std::vector<Vec2>& vertices) {
  Require(vertices.size() >= 3 && vertices.size() <= b2_maxPolygonVertices,
          "a polygon needs 3 to 8 vertices");
  for (const Vec2& vertex : vertices) RequirePosition(vertex);
  std::vector<b2Vec2> points;
  for (const Vec2& vertex : vertices) points.push_back(ToBox2D(vertex));
  Require(HasHull(points), "a polygon is too small or too thin: Box2D finds no area in it");
  b2PolygonShape shape;
  shape.Set(points.data(), static_cast<int32>(points.size()));
  return shape;
}

void RequireMaterial(const FixtureSettings& settings) {
  Require(
      settings.density == 0.0 || (IsUsable(settings.density) && settings.density >= kMinDensity),
      "density must be 0, or finite and 1e-6 kg/m^2 at least");
  RequireNotNegative(settings.friction, "friction must be finite and not negative");
  RequireNotNegative(settings.restitution, "restitution must be finite and not negative");
}

b2MassData ComputeMass(const b2Shape& shape, const FixtureSettings& settings) {
  b2MassData mass;
  shape.ComputeMass(&mass, static_cast<float>(settings.density));
  return mass;
}

// The same sums as in b2Body::ResetMassData, which asserts that the result is positive, in the same
// order and precision.
void RequireInertia(const std::vector<b2MassData>& newest_first) {
  float mass = 0.0f;
  float inertia = 0.0f;  // about the body's origin
  b2Vec2 moment = b2Vec2_zero;
  for (const b2MassData& part : newest_first) {
    mass += part.mass;
    inertia += part.I;
    moment += part.mass * part.center;
  }
  if (mass <= 0.0f || inertia <= 0.0f) return;  // Box2D does not get as far as the assertion
  const b2Vec2 center = (1.0f / mass) * moment;
  Require(inertia - mass * b2Dot(center, center) > 1e-6f * inertia,
          "a footprint is too small for its distance from the body's origin");
}

void FixtureChecker::AddCircle(Vec2 center, double radius, const FixtureSettings& settings) {
  Add(MakeCircle(center, radius), settings);
}

void FixtureChecker::AddPolygon(const std::vector<Vec2>& vertices,
                                const FixtureSettings& settings) {
  Add(MakePolygon(vertices), settings);
}

void FixtureChecker::Add(const b2Shape& shape, const FixtureSettings& settings) {
  RequireMaterial(settings);
  if (body_type_ != b2_dynamicBody) return;
  std::vector<b2MassData> parts{ComputeMass(shape, settings)};
  parts.insert(parts.end(), parts_.begin(), parts_.end());
  RequireInertia(parts);
  if (settings.density != 0.0) parts_ = std::move(parts);
}

}  // namespace flatland
