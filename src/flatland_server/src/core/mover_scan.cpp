#include "mover_scan.hpp"

#include <algorithm>
#include <limits>

namespace flatland {
namespace {
constexpr double kInfinity = std::numeric_limits<double>::infinity();
}

Mover::Mover(const b2Fixture& fixture, const Pose& lidar) {
  const b2Transform& body = fixture.GetBody()->GetTransform();
  const Rotation rotation(lidar.yaw);
  const auto to_lidar = [&](b2Vec2 local) {
    const Vec2 world{body.p.x + double{body.q.c} * local.x - double{body.q.s} * local.y,
                     body.p.y + double{body.q.s} * local.x + double{body.q.c} * local.y};
    return rotation.ApplyInverse(world - Vec2{lidar.x, lidar.y});
  };
  if (fixture.GetType() == b2Shape::e_circle) {
    const auto& circle = static_cast<const b2CircleShape&>(*fixture.GetShape());
    center_ = to_lidar(circle.m_p);
    radius_ = circle.m_radius;
  } else {
    const auto& polygon = static_cast<const b2PolygonShape&>(*fixture.GetShape());
    corner_count_ = polygon.m_count;
    center_ = to_lidar(polygon.m_centroid);
    for (int i = 0; i < corner_count_; ++i) {
      corners_[i] = to_lidar(polygon.m_vertices[i]);
      const Vec2 arm = corners_[i] - center_;
      radius_ = std::max(radius_, std::sqrt(Dot(arm, arm)));
    }
  }
  const double apart = std::sqrt(Dot(center_, center_));
  distance_ = std::max(0.0, apart - radius_);
  bearing_ = std::atan2(center_.y, center_.x);
  half_width_ = apart > radius_ ? std::asin(radius_ / apart) : M_PI;
}

double Mover::Cast(Vec2 direction) const {
  return corner_count_ == 0 ? CastAtCircle(direction) : CastAtPolygon(direction);
}

double Mover::CastAtCircle(Vec2 direction) const {
  const double outside = Dot(center_, center_) - radius_ * radius_;
  const double along = Dot(center_, direction);
  if (outside < 0.0 || along < 0.0) return kInfinity;
  const double across = Cross(direction, center_);
  const double half_chord_squared = radius_ * radius_ - across * across;
  if (half_chord_squared < 0.0) return kInfinity;
  return std::max(0.0, along - std::sqrt(half_chord_squared));
}

// A convex polygon is the intersection of half-planes: the ray is within it from where it has
// entered the last of them to where it leaves the first (Cyrus and Beck, 1978).
double Mover::CastAtPolygon(Vec2 direction) const {
  double enter = -kInfinity;
  double leave = kInfinity;
  for (int i = 0; i < corner_count_; ++i) {
    const Vec2 corner = corners_[i];
    const Vec2 side = corners_[i + 1 < corner_count_ ? i + 1 : 0] - corner;
    // How far outside this side the lidar is, and how fast the ray goes outwards: both times the
    // side's length.
    const double outside = Cross(side, corner);
    const double outwards = Cross(direction, side);
    if (outwards == 0.0) {
      if (outside > 0.0) return kInfinity;
    } else if (outwards < 0.0) {
      enter = std::max(enter, outside / -outwards);
    } else {
      leave = std::min(leave, -outside / outwards);
    }
  }
  return enter >= 0.0 && enter <= leave ? enter : kInfinity;
}

}  // namespace flatland
