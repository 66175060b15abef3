#pragma once

/// The walls that a lidar has seen in its last scan: the next one draws them first, and so has to
/// look at few others (depth_buffer.cpp). Ranges do not depend on it: it may be empty, old, or of
/// other walls. So it is no part of a saved state.

#include <cstdint>

#include "base/geometry.hpp"
#include "sight/segment_tree.hpp"

namespace flatland {

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

}  // namespace flatland
