#pragma once

/// Recorded walks of people, one after the other, which a body follows.

#include <cstdint>
#include <vector>

#include "base/geometry.hpp"

namespace flatland {

/// People who have not come yet, or have gone, are beyond this along both axes [m].
constexpr double kAway = 9e4;

struct Recording {
  /// Of one person, from its first to its last frame.
  struct Walk {
    std::vector<int64_t> times;  ///< [ns], ascending
    std::vector<Vec2> points;    ///< at these [m]
  };

  std::vector<Walk> walks;  ///< in the order of their times, without overlaps

  /// Throws std::invalid_argument if the walks are not as described.
  void Require() const;
  /// The walk that goes on at a time [ns]; -1 if there is none.
  int WalkAt(int64_t time) const;
  /// The point of a walk at a time [ns], or at its nearest end; straight between two frames.
  Vec2 PointAt(int walk, int64_t time) const;
};

}  // namespace flatland
