#pragma once

/// For visible_walls.cpp: finds the walls that can be seen from any point of a box.

#include <cstdint>
#include <optional>
#include <vector>

#include "base/geometry.hpp"
#include "sight/segment_tree.hpp"

namespace flatland {

/// Which walls share corners, to the last bit. The two ends of each wall are numbered.
class Corners {
 public:
  explicit Corners(const std::vector<Segment>& walls);

  static uint32_t EndOf(uint32_t wall) { return 2 * wall; }
  static uint32_t WallOf(uint32_t end) { return end / 2; }
  static uint32_t OtherEnd(uint32_t end) { return end ^ 1; }
  static Vec2 PointOf(const std::vector<Segment>& walls, uint32_t end) {
    const Segment& wall = walls[WallOf(end)];
    return end % 2 == 0 ? wall.a : wall.b;
  }
  /// The next end at the same corner; they are in a circle.
  uint32_t Next(uint32_t end) const { return next_[end]; }

 private:
  std::vector<uint32_t> next_;
};

/// Indices of walls that include all those that can be seen from a point of a box; none if finding
/// them would take long.
std::optional<std::vector<uint32_t>> WallsSeenFrom(const SegmentTree& walls, const Corners& corners,
                                                   const Box& box);

}  // namespace flatland
