#include "world/contact.hpp"

#include "base/box2d_limits.hpp"

namespace flatland {

bool Contact::is_enabled() const {
  const bool with_sensor = contact_.GetFixtureA()->IsSensor() || contact_.GetFixtureB()->IsSensor();
  return contact_.IsEnabled() && !with_sensor;
}

std::vector<Vec2> Contact::Points() const {
  b2WorldManifold manifold;
  contact_.GetWorldManifold(&manifold);
  std::vector<Vec2> points;
  for (int i = 0; i < contact_.GetManifold()->pointCount; ++i) {
    points.push_back({manifold.points[i].x, manifold.points[i].y});
  }
  return points;
}

Vec2 Contact::Normal() const {
  if (contact_.GetManifold()->pointCount == 0) return {};
  b2WorldManifold manifold;
  contact_.GetWorldManifold(&manifold);
  return {manifold.normal.x, manifold.normal.y};
}

void Contact::SetFriction(double friction) {
  RequireNotNegative(friction, "friction must be finite and not negative");
  contact_.SetFriction(static_cast<float>(friction));
}

void Contact::SetRestitution(double restitution) {
  RequireNotNegative(restitution, "restitution must be finite and not negative");
  contact_.SetRestitution(static_cast<float>(restitution));
}

void Contact::SetTangentSpeed(double speed) {
  Require(IsUsable(speed), "a tangent speed must be finite");
  contact_.SetTangentSpeed(static_cast<float>(speed));
}

}  // namespace flatland
