#pragma once

/// A search tree over the static walls of a layer, for lidars.
///
/// A tree of bounding boxes with eight children a node and eight walls a leaf, so that all of a
/// node or leaf are looked at together (tree_search.hpp). It is built once, by halving the walls
/// across one axis or the other, whichever makes the smaller boxes, at multiples of eight, 64, 512
/// ... walls. So all leaves but the last are full, and numbers alone tell what belongs to what:
/// child k of node i is number 8 i + k of the level below. DepthBuffer searches it.
///
/// Boxes and walls are in single precision. Boxes are made a little larger for that, and walls are
/// relative to the middle of their leaf.

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <utility>
#include <vector>

#include "base/geometry.hpp"

namespace flatland {

/// Indices of walls that belong to something else.
struct WallList {
  const uint32_t* indices = nullptr;
  size_t count = 0;
};

/// An axis-aligned bounding box [m]. Initially empty, with low above high.
struct Box {
  Vec2 low{1e300, 1e300};
  Vec2 high{-1e300, -1e300};

  void Add(Vec2 point) {
    low = {std::min(low.x, point.x), std::min(low.y, point.y)};
    high = {std::max(high.x, point.x), std::max(high.y, point.y)};
  }
  void Add(const Segment& segment) {
    Add(segment.a);
    Add(segment.b);
  }
  void Add(const Box& other) {
    low = {std::min(low.x, other.low.x), std::min(low.y, other.low.y)};
    high = {std::max(high.x, other.high.x), std::max(high.y, other.high.y)};
  }
  /// True if the two have a point in common.
  bool Meets(const Box& other) const {
    return low.x <= other.high.x && other.low.x <= high.x && low.y <= other.high.y &&
           other.low.y <= high.y;
  }
  /// The distance between the two [m], 0 if they meet.
  double Distance(const Box& other) const {
    return std::hypot(std::max({low.x - other.high.x, other.low.x - high.x, 0.0}),
                      std::max({low.y - other.high.y, other.low.y - high.y, 0.0}));
  }
  double half_perimeter() const { return high.x - low.x + high.y - low.y; }
  /// Square of the distance of a point [m^2], 0 within.
  double SquareDistance(Vec2 point) const {
    const double x = std::max(std::max(low.x - point.x, point.x - high.x), 0.0);
    const double y = std::max(std::max(low.y - point.y, point.y - high.y), 0.0);
    return x * x + y * y;
  }
};

class SegmentTree {
 public:
  /// Children of a node, and walls of a leaf.
  static constexpr int kWidth = 8;
  /// With no more walls, drawing all is faster than finding out which can be seen.
  static constexpr size_t kFew = 64;
  /// Walls between two reports of progress.
  static constexpr size_t kProgressStep = 50'000;

  /// Called with the number of walls that are in the tree so far, about every kProgressStep and at
  /// the end.
  using Progress = std::function<void(size_t done)>;

  /// The boxes of the children, relative to center() [m], as a structure of arrays. Unused places
  /// are infinitely far away.
  struct alignas(64) Node {
    float low_x[kWidth], low_y[kWidth], high_x[kWidth], high_y[kWidth];
  };

  /// Walls from (ax, ay) to (bx, by), relative to `center` [m], as a structure of arrays. Unused
  /// places are NaN, and repeat the last index.
  struct alignas(64) Leaf {
    float ax[kWidth], ay[kWidth], bx[kWidth], by[kWidth];
    uint32_t indices[kWidth];  ///< in segments()
    Vec2 center;
    float near_square;  ///< square of a distance within which rounding may matter [m^2]
  };

  explicit SegmentTree(std::vector<Segment> segments, const Progress& progress = {});

  size_t segment_count() const { return segments_.size(); }
  size_t leaf_count() const { return leaves_.size(); }
  const std::vector<Segment>& segments() const { return segments_; }
  Vec2 center() const { return center_; }
  const std::vector<Leaf>& leaves() const { return leaves_; }
  /// The nodes by level, first those with leaves as children, last a few that no node has as
  /// children. None without walls.
  const std::vector<std::vector<Node>>& levels() const { return levels_; }

  /// Calls `visit(index)`, with an index in segments(), for each wall of a leaf.
  template <class Visit>
  void ForEachWall(size_t leaf, Visit visit) const {
    const auto& indices = leaves_[leaf].indices;
    for (int i = 0; i < kWidth && (i == 0 || indices[i] != indices[i - 1]); ++i) visit(indices[i]);
  }
  /// Calls `visit(leaf)`, with the number of a leaf, in ascending order, for each leaf with a box
  /// that meets this one.
  template <class Visit>
  void ForEachLeafAt(const Box& box, Visit visit) const {
    for (size_t i = 0; i < top().size(); ++i) ForEachLeafAt(levels_.size() - 1, i, box, visit);
  }
  /// The least `distance(index)` of a wall, with an index in segments(), or `limit` if none is
  /// below it. Walls are skipped if their boxes are farther than the least distance so far from
  /// `box`.
  template <class Distance>
  double Least(const Box& box, double limit, Distance distance) const {
    for (size_t i = 0; i < top().size(); ++i) {
      limit = Least(levels_.size() - 1, i, box, limit, distance);
    }
    return limit;
  }

 private:
  using Iterator = std::vector<uint32_t>::iterator;

  const std::vector<Node>& top() const {
    static const std::vector<Node> none;
    return levels_.empty() ? none : levels_.back();
  }
  Box BoxOf(Iterator begin, Iterator end) const;
  void Arrange(Iterator begin, Iterator end, const Progress& progress, size_t* done) const;
  Leaf MakeLeaf(Iterator begin, Iterator end, const Box& box) const;
  std::vector<Node> MakeLevel(const std::vector<Box>& boxes) const;
  Box ChildBox(const Node& node, int k) const {
    return {center_ + Vec2{node.low_x[k], node.low_y[k]},
            center_ + Vec2{node.high_x[k], node.high_y[k]}};
  }
  template <class Visit>
  void ForEachLeafAt(size_t level, size_t number, const Box& box, Visit& visit) const {
    for (int k = 0; k < kWidth; ++k) {
      if (!ChildBox(levels_[level][number], k).Meets(box)) continue;
      if (level == 0) {
        visit(kWidth * number + k);
      } else {
        ForEachLeafAt(level - 1, kWidth * number + k, box, visit);
      }
    }
  }
  template <class Distance>
  double Least(size_t level, size_t number, const Box& box, double least,
               Distance& distance) const {
    std::array<std::pair<double, size_t>, kWidth> children;  // the nearest first
    for (int k = 0; k < kWidth; ++k) {
      children[k] = {ChildBox(levels_[level][number], k).Distance(box), kWidth * number + k};
    }
    std::sort(children.begin(), children.end());
    for (const auto& [near, child] : children) {
      if (!(near < least)) break;
      if (level > 0) {
        least = Least(level - 1, child, box, least, distance);
      } else {
        ForEachWall(child, [&, &least = least](uint32_t index) {
          least = std::min(least, static_cast<double>(distance(index)));
        });
      }
    }
    return least;
  }

  std::vector<Segment> segments_;
  std::vector<Leaf> leaves_;
  std::vector<std::vector<Node>> levels_;
  Vec2 center_;  // of all walls
  double margin_ = 0.0;
};

}  // namespace flatland
