#pragma once

/// What a lidar sees: the distance of the nearest thing along each of its beams.
///
/// The need: a thousand beams ten times a second, of a hundred robots, and the answers of exact
/// geometry. Casting one ray after the other tries every wall once for each beam that comes near.
///
/// The method: the other way round, as a rasteriser does. Each wall is drawn once, onto the beams
/// between its two ends, and each beam keeps the nearest. Along a wall from a to b, as seen by the
/// lidar, a beam of direction u meets it at the distance t with
///
///     1 / t = cross(u, b - a) / cross(a, b)
///
/// which is linear in u: so the inverse is kept, and a wall costs each beam two products and a
/// comparison, four beams at a time, and no division. Whether u lies between the ends is the sign
/// of cross(a, u) and cross(u, b), exactly; which beams to ask comes from a table (`BeamFan`).
///
/// Walls come from a tree of boxes (`SegmentTree`), the nearer box first. A box is passed over,
/// with all in it, if every beam towards it has met something nearer. In an office, 4 of 100 walls
/// are looked at, and each beam is compared with 5 of them.
///
/// All arithmetic is in double precision, and the same on every processor: AVX2, where there is
/// one, does four at a time what others do one by one or two by two.

#include <vector>

#include "flatland_server/beam_fan.hpp"
#include "flatland_server/geometry.hpp"
#include "flatland_server/segment_tree.hpp"

namespace flatland {

/// Bounding circles in the world, coordinate by coordinate: centres and radii [m]. There is room
/// for a multiple of BeamFan::kGroup.
struct Discs {
  std::vector<double> x;
  std::vector<double> y;
  std::vector<double> radius;
  int count = 0;

  void Clear() { count = 0; }
  void Add(Vec2 center, double radius);
};

class DepthBuffer {
 public:
  /// Forgets all; sees nothing beyond `range` [m]. The fan must live as long as it is drawn on.
  void Begin(const BeamFan& fan, double range);

  /// Walls, seen from a lidar in their frame.
  void Draw(const SegmentTree& walls, const Pose& lidar);

  /// The places in `discs` of those of which something may be seen: they are in range, and not all
  /// beams towards them end before. Valid until the next call.
  const std::vector<int>& FindSeen(const Discs& discs, const Pose& lidar);

  // Shapes in the lidar's frame. One that is around the lidar is not seen from within.
  void DrawCircle(Vec2 center, double radius);
  /// Convex, counter-clockwise.
  void DrawPolygon(const Vec2* corners, int count);

  /// What is drawn from now on reflects, and wins from what is equally far.
  void BeginReflecting();

  /// By beam: the distance [m], or +infinity where nothing is in range (REP 117).
  void GetRanges(float* ranges) const;
  /// By beam: 255 if what is seen reflects, 0 otherwise.
  void GetIntensities(float* intensities) const;

 private:
  const BeamFan* fan_ = nullptr;
  double range_ = 0.0;
  double beyond_ = 0.0;  // the inverse distance [1/m] of a beam that meets nothing: a little less
                         // than at its range
  // By rank: inverse distances [1/m].
  std::vector<double> inverse_;
  std::vector<double> dull_;  // of what does not reflect; empty until something does
  std::vector<int> seen_;     // what FindSeen has found
};

}  // namespace flatland
