#pragma once

/// For WallSearch: scans from the corners of a box. A wall that one of them sees can be seen from
/// the box, so that there is nothing to be searched for.

#include <vector>

#include "flatland_server/depth_buffer.hpp"
#include "flatland_server/geometry.hpp"
#include "flatland_server/segment_tree.hpp"

namespace flatland {

class CornerScans {
 public:
  /// The walls must outlive it.
  CornerScans(const SegmentTree& walls, const Box& box);

  /// Makes the next scan. Returns false if all of them have been made.
  bool MakeNext();
  /// True if a beam of one of them ends on a wall.
  bool See(const Segment& wall) const;

 private:
  static constexpr int kCount = BeamFan::kGroup;

  const SegmentTree& walls_;
  double x_[kCount], y_[kCount];  // the corners
  DepthBuffer buffer_;
  std::vector<float> ranges_;  // of one scan after the other
};

}  // namespace flatland
