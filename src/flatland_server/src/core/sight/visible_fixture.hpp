#pragma once

/// Fixtures of bodies, as lidars see them.
///
/// Bodies move, so their fixtures are not in the search tree of the walls (SegmentTree). Each scan
/// tests their bounding circles, and draws those that are in range and not hidden.

#include <box2d/box2d.h>

#include "base/collision_layers.hpp"
#include "base/geometry.hpp"
#include "sight/depth_buffer.hpp"

namespace flatland {

/// Centre of the bounding circle of a circle or polygon, in the body's frame [m].
b2Vec2 CentroidOf(const b2Shape& shape);

/// Radius of the bounding circle of a circle or polygon about its centroid [m].
double BoundingRadius(const b2Shape& shape);

/// A fixture that lidars see, at the present pose of its body.
struct VisibleFixture {
  /// `bounding_radius` is that of the fixture's shape [m].
  VisibleFixture(const b2Fixture& fixture, double bounding_radius);

  /// Draws the shape as seen by a lidar at `origin`, rotated by `rotation`, in the world.
  void DrawOn(DepthBuffer& buffer, Vec2 origin, const Rotation& rotation) const;

  const b2Fixture* fixture;
  LayerBits layers;
  Vec2 center;             ///< of the bounding circle, in the world [m]
  double bounding_radius;  ///< [m]
};

}  // namespace flatland
