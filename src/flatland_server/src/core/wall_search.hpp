#pragma once

/// The search for the walls that can be seen from a box, in portions; visible_walls.hpp has the
/// method. What is known at once comes first: walls that face away, those that scans from the
/// corners see (corner_scans.hpp), and those in the umbra of the occluders (umbras.hpp). Sight
/// lines to the others (sight_lines.hpp) are halved until single occluders block them all, or one
/// is found that none blocks (four_occluders.hpp).

#include <cstdint>
#include <memory>
#include <vector>

#include "flatland_server/geometry.hpp"
#include "flatland_server/segment_tree.hpp"
#include "occluders.hpp"

namespace flatland {

class WallSearch {
 public:
  /// Of the walls of a tree, from a box. The tree and what hides its walls must outlive it.
  /// `among`: those that can be seen from a box around it, if they are known; this is much quicker.
  WallSearch(const SegmentTree& walls, const Occluders& occluders, const Box& from,
             const std::vector<uint32_t>* among = nullptr);
  ~WallSearch();

  /// Goes on until it has looked at about so many occluders, and at least at one wall or box of the
  /// tree. Returns whether it has ended.
  bool Continue(int effort);
  /// After its end: the indices in segments() of the walls that can be seen, and perhaps of more,
  /// in the order of the leaves. The order of portions does not change them.
  const std::vector<uint32_t>& seen() const;

 private:
  class Finder;
  std::unique_ptr<Finder> finder_;
};

}  // namespace flatland
