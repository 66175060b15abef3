#pragma once

/// Some walls of a layer in the order in which they are drawn, for lidars near one place.
///
/// A tree of boxes finds the few walls of thousands that a lidar may see. Where these are known
/// beforehand (VisibleWalls), there is little left to find, and following the tree takes longer
/// than drawing. So the walls are in blocks of neighbours, the block next to the place first.

#include <array>
#include <cstdint>
#include <vector>

#include "flatland_server/beam_fan.hpp"
#include "flatland_server/geometry.hpp"
#include "flatland_server/segment_tree.hpp"

namespace flatland {

class WallList {
 public:
  static constexpr int kBlockSize = SegmentTree::kLeafSize;

  /// Neighbouring walls, in one cache line. Unused places repeat the last one.
  struct Block {
    Box box;
    std::array<uint32_t, kBlockSize> indices;  ///< in walls()
  };

  /// The walls with these indices in an array, which must outlive the list. Walls that are near to
  /// each other should be so in `indices`, too. `place` [m] is where lidars are.
  WallList(const std::vector<Segment>& walls, const std::vector<uint32_t>& indices, Vec2 place);

  const Segment* walls() const { return walls_; }
  using Blocks = std::vector<Block, AlignedAllocator<Block>>;
  const Blocks& blocks() const { return blocks_; }
  size_t size() const { return size_; }

 private:
  const Segment* walls_;
  Blocks blocks_;
  size_t size_;
};

}  // namespace flatland
