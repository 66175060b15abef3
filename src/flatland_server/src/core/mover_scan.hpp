#pragma once

/// A body's fixture as a lidar sees it. Bodies are few and move, so they are not indexed: each is
/// brought into the lidar's frame once per scan, and only the beams towards its bounding circle are
/// cast at it.

#include <box2d/box2d.h>

#include <array>

#include "flatland_server/geometry.hpp"

namespace flatland {

class Mover {
 public:
  Mover(const b2Fixture& fixture, const Pose& lidar);

  /// From the lidar to the bounding circle [m]; 0 within it.
  double distance() const { return distance_; }
  /// Direction of the bounding circle's centre, and half the angle that it takes up [rad].
  double bearing() const { return bearing_; }
  double half_width() const { return half_width_; }

  /// Distance [m] from the lidar along a unit vector in its frame to the shape's outside, or
  /// +infinity. A shape around the lidar is not seen from within.
  double Cast(Vec2 direction) const;

 private:
  double CastAtCircle(Vec2 direction) const;
  double CastAtPolygon(Vec2 direction) const;

  std::array<Vec2, b2_maxPolygonVertices> corners_;  // counter-clockwise, in the lidar's frame
  int corner_count_ = 0;                             // 0 for a circle
  Vec2 center_;                                      // of the circle, or of the bounding circle
  double radius_ = 0.0;
  double distance_ = 0.0;
  double bearing_ = 0.0;
  double half_width_ = 0.0;
};

}  // namespace flatland
