#pragma once

/// For depth_buffer.cpp and walls_seen_from.cpp: finds the walls of a SegmentTree that a horizon
/// does not hide. Level by level, eight boxes are looked at together: which beams may meet each,
/// and how near it is. No branch is there that a processor may guess wrongly: what is not hidden
/// goes to a list for the next level. In single precision, with margins to be on the safe side;
/// what is drawn is computed in double precision.

#include <algorithm>
#include <cstring>
#include <numeric>
#include <utility>
#include <vector>

#include "base/geometry.hpp"
#include "sight/doubles.hpp"
#include "sight/horizon.hpp"
#include "sight/segment_tree.hpp"

namespace flatland {

static_assert(SegmentTree::kWidth == kEight);

/// A lidar's pose, also relative to the centre of a tree, the buckets of its diamond angles, and
/// the distances that are looked at [m].
struct TreeView {
  TreeView(const SegmentTree& walls, Vec2 origin, const Rotation& rotation, double buckets_per_unit,
           float from, float to)
      : origin(origin),
        x(static_cast<float>(origin.x - walls.center().x)),
        y(static_cast<float>(origin.y - walls.center().y)),
        cos(static_cast<float>(rotation.cos)),
        sin(static_cast<float>(rotation.sin)),
        buckets_per_unit(static_cast<float>(buckets_per_unit)),
        min_square(from * from),
        max_square(to * to) {}

  Vec2 origin;
  float x, y, cos, sin, buckets_per_unit;
  float min_square, max_square;  // [m^2]
};

/// Boxes or walls as seen by the lidar, as a structure of arrays.
struct Lanes {
  static constexpr int kMost = 8 * kEight;
  // The beams that may meet each: from the bucket of its right edge (BeamFan) to that of its left
  // one; `wraps` if they contain the backward direction.
  int from[kMost], to[kMost], wraps[kMost];
  // Its inverse square distance, or a little more; infinite if the lidar is within, 0 if it is not
  // to be looked at. It is hidden if all of these beams have at least that.
  float nearness[kMost];
  int number[kMost];  // of the child, or index of the wall
};

/// Much more than the rounding error of a diamond angle in single precision.
constexpr float kAngleMargin = 1e-5f;
/// The same for a ratio of square distances.
constexpr float kDistanceMargin = 1.001f;

/// Fills eight lanes, of things between two diamond angles. Those that the lidar is in or near to,
/// `is_around`, may be met by all beams.
FLATLAND_INLINE void FillLanes(const EightFloats& right_angles, const EightFloats& left_angles,
                               const EightFloats& square_distances, const EightInts& is_around,
                               const EightInts& is_in_range, const TreeView& view, Lanes& lanes,
                               int lane) {
  const EightFloats right = right_angles - kAngleMargin, left = left_angles + kAngleMargin;
  // Max and Min replace NaN, too.
  const EightFloats first = FillEight(-2.0f), last = FillEight(2.0f), zero = FillEight(0.0f);
  const EightFloats from = is_around ? first : Max(right < -2.0f ? right + 4.0f : right, first);
  const EightFloats to = is_around ? last : Min(left > 2.0f ? left - 4.0f : left, last);
  Store(ToInts((from + 2.0f) * view.buckets_per_unit), lanes.from + lane);
  Store(ToInts((to + 2.0f) * view.buckets_per_unit), lanes.to + lane);
  Store(from > to, lanes.wraps + lane);
  const EightFloats nearness = kDistanceMargin / (is_around ? zero : square_distances);
  Store(is_in_range ? nearness : zero, lanes.nearness + lane);
}

/// Looks at the children of a node.
FLATLAND_INLINE void ViewBoxes(const SegmentTree::Node& node, int number, const TreeView& view,
                               Lanes& lanes, int lane) {
  const EightFloats low_x = Load(node.low_x) - view.x, low_y = Load(node.low_y) - view.y;
  const EightFloats high_x = Load(node.high_x) - view.x, high_y = Load(node.high_y) - view.y;
  const EightFloats zero = FillEight(0.0f);
  const EightFloats near_x = Max(Max(low_x, -high_x), zero);
  const EightFloats near_y = Max(Max(low_y, -high_y), zero);
  const EightFloats far_x = Max(-low_x, high_x), far_y = Max(-low_y, high_y);
  const EightFloats square_near = near_x * near_x + near_y * near_y;
  const EightFloats square_far = far_x * far_x + far_y * far_y;
  // The outermost corners as seen from outside.
  const EightInts is_right = low_x > 0.0f, is_left = high_x < 0.0f;  // of the lidar
  const EightInts is_above = low_y > 0.0f, is_below = high_y < 0.0f;
  const EightFloats side_x = is_right ? low_x : high_x, side_y = is_above ? low_y : high_y;
  const EightFloats right_x = is_above ? high_x : is_below ? low_x : side_x;
  const EightFloats left_x = is_above ? low_x : is_below ? high_x : side_x;
  const EightFloats right_y = is_right ? low_y : is_left ? high_y : side_y;
  const EightFloats left_y = is_right ? high_y : is_left ? low_y : side_y;
  FillLanes(
      DiamondAngles(view.cos * right_x + view.sin * right_y,
                    view.cos * right_y - view.sin * right_x),
      DiamondAngles(view.cos * left_x + view.sin * left_y, view.cos * left_y - view.sin * left_x),
      square_near, square_near <= 0.0f,
      (square_near < view.max_square) & (square_far >= view.min_square), view, lanes, lane);
  Store(EightInts{0, 1, 2, 3, 4, 5, 6, 7} + kEight * number, lanes.number + lane);
}

/// Looks at the walls of a leaf.
FLATLAND_INLINE void ViewWallsOf(const SegmentTree::Leaf& leaf, const TreeView& view, Lanes& lanes,
                                 int lane) {
  const auto x = static_cast<float>(view.origin.x - leaf.center.x);
  const auto y = static_cast<float>(view.origin.y - leaf.center.y);
  const EightFloats world_ax = Load(leaf.ax) - x, world_ay = Load(leaf.ay) - y;
  const EightFloats world_bx = Load(leaf.bx) - x, world_by = Load(leaf.by) - y;
  const EightFloats ax = view.cos * world_ax + view.sin * world_ay;
  const EightFloats ay = view.cos * world_ay - view.sin * world_ax;
  const EightFloats bx = view.cos * world_bx + view.sin * world_by;
  const EightFloats by = view.cos * world_by - view.sin * world_bx;
  // The nearest point.
  const EightFloats along_x = bx - ax, along_y = by - ay;
  const EightFloats part = -(ax * along_x + ay * along_y) / (along_x * along_x + along_y * along_y);
  const EightFloats clamped = Min(Max(part, FillEight(0.0f)), FillEight(1.0f));
  const EightFloats near_x = ax + clamped * along_x, near_y = ay + clamped * along_y;
  const EightFloats square_near = near_x * near_x + near_y * near_y;
  const EightInts swap = ax * by - ay * bx < 0.0f;
  const EightFloats a = DiamondAngles(ax, ay), b = DiamondAngles(bx, by);
  FillLanes(swap ? b : a, swap ? a : b, square_near, square_near <= leaf.near_square,
            (square_near >= view.min_square) & (square_near < view.max_square), view, lanes, lane);
  std::memcpy(lanes.number + lane, leaf.indices, sizeof(leaf.indices));
}

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
