#pragma once

/// Tells which straight lines are blocked by walls.

#include <memory>
#include <vector>

#include "base/geometry.hpp"
#include "sight/segment_tree.hpp"

namespace flatland {

class LinesOfSight {
 public:
  explicit LinesOfSight(std::vector<Segment> walls);

  /// True if a wall crosses a line; false if the line is not finite.
  bool IsBlocked(const Segment& line) const;

 private:
  std::shared_ptr<const SegmentTree> walls_;
};

}  // namespace flatland
