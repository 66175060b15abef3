#include "world/fixture.hpp"

#include "base/box2d_limits.hpp"
#include "base/to_box2d.hpp"

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

b2MassData ComputeMass(const b2Shape& shape, double density) {
  b2MassData mass;
  shape.ComputeMass(&mass, static_cast<float>(density));
  return mass;
}

void RequireInertia(const b2MassData& mass, const char* message) {
  // The same difference, in the same precision, as in b2Body::SetMassData.
  Require(mass.I - mass.mass * b2Dot(mass.center, mass.center) > 1e-6f * mass.I, message);
}

MassSum MassSum::With(const b2MassData& fixture) const {
  MassSum sum = *this;
  sum.mass_ += fixture.mass;
  sum.inertia_ += fixture.I;
  sum.moment_ = sum.moment_ + double{fixture.mass} * FromBox2D(fixture.center);
  const b2MassData total = sum.ToBox2D();
  if (total.mass <= 0.0f || total.I <= 0.0f) return sum;  // Box2D asserts nothing then
  RequireInertia(total, "a footprint is too small for its distance from the body's origin");
  return sum;
}

b2MassData MassSum::ToBox2D() const {
  b2MassData data;
  data.mass = static_cast<float>(mass_);
  data.I = static_cast<float>(inertia_);
  data.center = mass_ > 0.0 ? flatland::ToBox2D((1.0 / mass_) * moment_) : b2Vec2_zero;
  return data;
}

}  // namespace flatland
