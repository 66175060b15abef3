#pragma once

/// A polar depth buffer: the nearest distance along each beam of a lidar.
///
/// Used in this order: Begin; Draw the walls of each layer; FindVisible, and DrawCircle or
/// DrawPolygon for the fixtures that it finds; GetRanges and GetIntensities. How it works is
/// explained at the top of depth_buffer.cpp.

#include <cstdint>
#include <memory>
#include <vector>

#include "base/geometry.hpp"
#include "sight/beam_fan.hpp"
#include "sight/segment_tree.hpp"

namespace flatland {

/// Bounding circles in the world, as a structure of arrays, padded to a multiple of
/// BeamFan::kGroup.
struct BoundingCircles {
  std::vector<double> x;       ///< of the centre [m]
  std::vector<double> y;       ///< of the centre [m]
  std::vector<double> radius;  ///< [m]
  int count = 0;

  void Clear() { count = 0; }
  void Add(Vec2 center, double circle_radius);
};

/// The walls that a lidar has seen in its last scan: the next one draws them first, and so has to
/// look at few others. Ranges do not depend on it: it may be empty, old, or of other walls. So it
/// is no part of a saved state.
struct SeenWalls {
  static constexpr int kMost = 250;

  Vec2 place;     ///< of the lidar, in the world [m]
  int count = 0;  ///< 0 if nothing is known
  // Only to be fetched in time.
  WallList known;                     ///< those known to be visible from its cell of the floor
  const Segment* segments = nullptr;  ///< of all walls
  const void* cell = nullptr;         ///< that cell
  uint32_t walls[kMost];              ///< indices, each of them once
};

class Horizon;
struct LidarView;
struct SearchLists;

class DepthBuffer {
 public:
  DepthBuffer();
  ~DepthBuffer();

  /// Starts a scan of the fan's beams up to `range` [m]. The fan must outlive the scan.
  void Begin(const BeamFan& fan, double range);

  /// Draws all walls, as seen by a lidar at this pose in their frame. The walls that this lidar saw
  /// in its last scan make it faster, and are replaced; null if they are not known.
  void Draw(const SegmentTree& walls, const Pose& lidar, SeenWalls* seen = nullptr);
  /// Draws only the walls with these indices (VisibleWalls).
  void Draw(const SegmentTree& walls, WallList only, const Pose& lidar);

  /// Indices of the circles in range that what is drawn so far does not hide. Valid until the next
  /// call.
  const std::vector<int>& FindVisible(const BoundingCircles& circles, const Pose& lidar);

  // Shapes in the lidar's frame [m]. A shape that contains the lidar, or is within a millimetre of
  // it, is not drawn.
  void DrawCircle(Vec2 center, double radius);
  /// A convex polygon, its corners in counter-clockwise order.
  void DrawPolygon(const Vec2* corners, int count);

  /// Everything drawn from now on reflects. At equal distances it hides what was drawn before.
  void BeginReflecting();

  /// Writes the distance of each beam [m], or +infinity if nothing is in range (REP 117).
  void GetRanges(float* ranges) const;
  /// Writes 255 for each beam that ends on something that reflects, and 0 for the others.
  void GetIntensities(float* intensities) const;

 private:
  LidarView ViewFrom(const Pose& lidar);

  const BeamFan* fan_ = nullptr;
  double range_ = 0.0;        // [m]
  double min_inverse_ = 0.0;  // inverse distance just beyond the range: that of a free beam [1/m]
  // By rank of the beam: inverse distance of the nearest thing [1/m].
  AlignedDoubles inverse_;
  AlignedDoubles non_reflecting_;  // before BeginReflecting; empty if that was not called
  std::unique_ptr<Horizon> horizon_;
  std::unique_ptr<SearchLists> lists_;
  std::vector<char> is_drawn_;  // by wall, while a tree is drawn
  std::vector<int> visible_;    // result of FindVisible
};

}  // namespace flatland
