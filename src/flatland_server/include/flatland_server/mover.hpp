#pragma once

/// A body's fixture as a lidar sees it. What moves is not indexed: its bounding circle is looked at
/// in each scan, and unless that is out of range or behind something, it is drawn.

#include <box2d/box2d.h>

#include "flatland_server/depth_buffer.hpp"
#include "flatland_server/geometry.hpp"

namespace flatland {

/// How far a circle or a polygon reaches from its middle, its `MiddleOf` [m].
double ReachOf(const b2Shape& shape);

struct Mover {
  /// `reach` is that of the fixture's shape.
  Mover(const b2Fixture& fixture, double reach);

  /// Draws it as seen from a lidar at `origin`, turned by `rotation`.
  void DrawOn(DepthBuffer& buffer, Vec2 origin, const Rotation& rotation) const;

  const b2Fixture* fixture;
  uint16_t layers;
  Vec2 middle;   ///< of the bounding circle, in the world [m]
  double reach;  ///< its radius [m]
};

}  // namespace flatland
