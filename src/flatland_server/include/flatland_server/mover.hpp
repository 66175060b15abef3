#pragma once

/// A body's fixture as a lidar sees it. What moves is not indexed: it is brought into the lidar's
/// frame for each scan, unless its bounding circle is out of range or behind something.

#include <box2d/box2d.h>

#include "flatland_server/depth_buffer.hpp"
#include "flatland_server/geometry.hpp"

namespace flatland {

/// How far a circle or a polygon reaches from its middle, its `MiddleOf` [m].
double ReachOf(const b2Shape& shape);

struct Mover {
  /// `reach` is that of the fixture's shape.
  Mover(const b2Fixture& fixture, double reach);

  /// Draws it as seen from a lidar at `origin`, turned by `rotation`, that sees as far as `range`.
  void DrawOn(DepthBuffer& buffer, Vec2 origin, const Rotation& rotation, double range) const;

  const b2Fixture* fixture;
  uint16_t layers;
  Vec2 middle;   ///< of the bounding circle, in the world [m]
  double reach;  ///< its radius [m]
};

}  // namespace flatland
