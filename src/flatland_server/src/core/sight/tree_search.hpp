#pragma once

/// For depth_buffer.cpp and visible_walls.cpp: finds the walls of a SegmentTree that a horizon does
/// not hide. Level by level, eight boxes are looked at together (tree_view.hpp), without a branch
/// that a processor may guess wrongly: what is not hidden goes to a list for the next level.

#include <algorithm>
#include <numeric>
#include <utility>
#include <vector>

#include "sight/horizon.hpp"
#include "sight/tree_view.hpp"

namespace flatland {

/// What hides walls: `horizon` has a value for each of `size` directions, of which before[i] are
/// before bucket i.
struct Hiding {
  const Horizon& horizon;
  const int* before;
  int size;
};

/// Numbers of nodes and leaves to look at.
struct SearchLists {
  void MakeRoomFor(const SegmentTree& walls) {
    for (std::vector<int>* list : {&here, &next}) {
      list->resize(std::max(list->size(), walls.leaf_count() + 2 * kEight));
    }
  }
  std::vector<int> here, next;
};

/// Appends the numbers of the lanes that are not hidden. `list` must have room for one more.
FLATLAND_INLINE int AppendVisible(const Lanes& lanes, int count, const Hiding& hiding, int* list) {
  int found = 0;
  for (int k = 0; k < count; ++k) {
    const int begin = hiding.before[lanes.from[k]], end = hiding.before[lanes.to[k] + 1];
    float least;
    if (__builtin_expect(lanes.wraps[k], 0)) {
      least = std::min(hiding.horizon.Least(begin, hiding.size), hiding.horizon.Least(0, end));
    } else {
      least = hiding.horizon.Least(begin, end);
    }
    list[found] = lanes.number[k];
    found += static_cast<int>(least < lanes.nearness[k]);
  }
  return found;
}

/// Calls `take(indices, count)` with walls that are not hidden, up to Lanes::kMost at a time. The
/// lists have room for the tree.
template <class Take>
FLATLAND_INLINE void FindUnhidden(const SegmentTree& walls, const TreeView& tree,
                                  const Hiding& hiding, SearchLists& lists, Take take) {
  constexpr int kNodes = Lanes::kMost / kEight;  // looked at together
  Lanes lanes;
  int* list = lists.here.data();
  int* next = lists.next.data();
  int count = static_cast<int>(walls.levels().back().size());
  std::iota(list, list + count, 0);
  for (size_t level = walls.levels().size(); level-- > 0;) {
    const SegmentTree::Node* const nodes = walls.levels()[level].data();
    int found = 0;
    for (int begin = 0; begin < count; begin += kNodes) {
      const int here = std::min(count - begin, kNodes);
      for (int i = 0; i < here; ++i) {
        ViewBoxes(nodes[list[begin + i]], list[begin + i], tree, lanes, kEight * i);
      }
      found += AppendVisible(lanes, kEight * here, hiding, next + found);
    }
    std::swap(list, next);
    count = found;
  }
  for (int begin = 0; begin < count; begin += kNodes) {
    const int here = std::min(count - begin, kNodes);
    for (int i = 0; i < here; ++i) {
      ViewWallsOf(walls.leaves()[list[begin + i]], tree, lanes, kEight * i);
    }
    int visible[Lanes::kMost + 1];
    take(visible, AppendVisible(lanes, kEight * here, hiding, visible));
  }
}

}  // namespace flatland
