#include "sight/visible_fixture.hpp"

#include <algorithm>

namespace flatland {
namespace {

Vec2 ToWorld(const b2Transform& body, b2Vec2 local) {
  return {body.p.x + double{body.q.c} * local.x - double{body.q.s} * local.y,
          body.p.y + double{body.q.s} * local.x + double{body.q.c} * local.y};
}

}  // namespace

b2Vec2 CentroidOf(const b2Shape& shape) {
  return shape.GetType() == b2Shape::e_circle
             ? static_cast<const b2CircleShape&>(shape).m_p
             : static_cast<const b2PolygonShape&>(shape).m_centroid;
}

double BoundingRadius(const b2Shape& shape) {
  if (shape.GetType() == b2Shape::e_circle) return shape.m_radius;
  const auto& polygon = static_cast<const b2PolygonShape&>(shape);
  double radius = 0.0;
  for (int i = 0; i < polygon.m_count; ++i) {
    const Vec2 arm{double{polygon.m_vertices[i].x} - polygon.m_centroid.x,
                   double{polygon.m_vertices[i].y} - polygon.m_centroid.y};
    radius = std::max(radius, LengthOf(arm));
  }
  return radius;
}

VisibleFixture::VisibleFixture(const b2Fixture& fixture, double bounding_radius)
    : fixture(&fixture),
      layers(fixture.GetFilterData().categoryBits),
      center(ToWorld(fixture.GetBody()->GetTransform(), CentroidOf(*fixture.GetShape()))),
      bounding_radius(bounding_radius) {}

void VisibleFixture::DrawOn(DepthBuffer& buffer, Vec2 origin, const Rotation& rotation) const {
  if (fixture->GetType() == b2Shape::e_circle) {
    buffer.DrawCircle(rotation.ApplyInverse(center - origin), bounding_radius);
    return;
  }
  const auto& polygon = static_cast<const b2PolygonShape&>(*fixture->GetShape());
  const b2Transform& body = fixture->GetBody()->GetTransform();
  Vec2 corners[b2_maxPolygonVertices];
  for (int i = 0; i < polygon.m_count; ++i) {
    corners[i] = rotation.ApplyInverse(ToWorld(body, polygon.m_vertices[i]) - origin);
  }
  buffer.DrawPolygon(corners, polygon.m_count);
}

}  // namespace flatland
