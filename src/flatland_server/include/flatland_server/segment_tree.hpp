#pragma once

/// A search tree over the static walls of a layer, for lidars.
///
/// A binary tree of bounding boxes, built once. The walls of a node are divided between two
/// children such that their boxes are small for the number of walls in them (the surface area
/// heuristic: MacDonald and Booth, "Heuristics for Ray Tracing Using Space Subdivision", 1990; here
/// with perimeters). A leaf holds up to kLeafSize walls. DepthBuffer traverses the tree.
///
/// A leaf has a copy of its walls' coordinates, side by side; in a large tree, to save memory, only
/// their indices.

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <functional>
#include <memory>
#include <vector>

#include "flatland_server/geometry.hpp"

namespace flatland {

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
  static constexpr int kLeafSize = 8;
  /// No path from the root is longer than this.
  static constexpr int kMaxDepth = 96;
  /// Trees of more walls are large.
  static constexpr size_t kMaxCopied = 500'000;

  /// Walls between two reports of progress.
  static constexpr size_t kProgressStep = 50'000;

  /// Called with the number of walls that are in the tree so far, about every kProgressStep and at
  /// the end.
  using Progress = std::function<void(size_t done)>;

  /// Walls from (ax, ay) to (bx, by) [m], as a structure of arrays, so that several are computed at
  /// a time. Unused places are NaN.
  struct Leaf {
    double ax[kLeafSize];
    double ay[kLeafSize];
    double bx[kLeafSize];
    double by[kLeafSize];
  };

  struct Child {
    Box box;
    /// Index of a node, or the complement (~) of the index of a leaf.
    int32_t index = 0;
    bool is_leaf() const { return index < 0; }
  };

  struct Node {
    Child children[2];
  };

  using Indices = std::array<uint32_t, kLeafSize>;

  /// `max_copied` is the largest number of segments of which leaves have copies.
  explicit SegmentTree(std::vector<Segment> segments, const Progress& progress = {},
                       size_t max_copied = kMaxCopied);

  /// An existing tree of equal segments, or a new one. So all worlds with the same map share one.
  static std::shared_ptr<const SegmentTree> Share(std::vector<Segment> segments,
                                                  const Progress& progress = {});

  size_t segment_count() const { return segments_.size(); }
  size_t leaf_count() const { return indices_.size(); }
  const std::vector<Segment>& segments() const { return segments_; }
  /// The whole tree, in the form of a node's child. The box of an empty tree is empty.
  const Child& root() const { return root_; }
  const Node& node(const Child& child) const { return nodes_[child.index]; }
  /// A leaf's copies of its walls, or null in a large tree.
  const Leaf* leaf(const Child& child) const {
    return leaves_.empty() ? nullptr : &leaves_[~child.index];
  }
  /// The indices in segments() of a leaf's walls, by their places in it. Unused places repeat the
  /// last one.
  const Indices& indices(const Child& child) const { return indices_[~child.index]; }
  /// Calls `visit(index)`, with an index in segments(), for each wall of a leaf while it returns
  /// true; returns whether it did. Leaves are numbered in the order of the tree.
  template <class Visit>
  bool ForEachWall(size_t leaf, Visit visit) const {
    const Indices& indices = indices_[leaf];
    for (int i = 0; i < kLeafSize; ++i) {
      if (i > 0 && indices[i] == indices[i - 1]) break;
      if (!visit(indices[i])) return false;
    }
    return true;
  }
  /// Calls `visit(leaf)`, with the number of a leaf, in ascending order, for each leaf with a box
  /// that meets this one.
  template <class Visit>
  void ForEachLeafAt(const Box& box, Visit visit) const {
    if (!segments_.empty()) ForEachLeafAt(root_, box, visit);
  }
  /// The least `distance(index)` of a wall, with an index in segments(), or `limit` if none is
  /// below. Walls with boxes farther than that from this box are left out.
  template <class Distance>
  double Least(const Box& box, double limit, Distance distance) const {
    return segments_.empty() ? limit : Least(root_, box, limit, distance);
  }

 private:
  using Iterator = std::vector<uint32_t>::iterator;

  /// Progress of filling the tree.
  struct Filling {
    const Progress& progress;
    bool has_copies;  // in its leaves
    size_t done = 0;  // walls in leaves
  };

  Child Build(Iterator begin, Iterator end, int depth, Filling& filling);
  Iterator Split(Iterator begin, Iterator end, int depth);
  int32_t AddLeaf(Iterator begin, Iterator end, Filling& filling);
  void AddCopies(Iterator begin, Iterator end);
  template <class Visit>
  void ForEachLeafAt(const Child& child, const Box& box, Visit& visit) const {
    if (!child.box.Meets(box)) return;
    if (child.is_leaf()) {
      visit(static_cast<size_t>(~child.index));
      return;
    }
    for (const Child& each : node(child).children) ForEachLeafAt(each, box, visit);
  }
  template <class Distance>
  double Least(const Child& child, const Box& box, double least, Distance& distance) const {
    if (child.box.Distance(box) >= least) return least;
    if (child.is_leaf()) {
      ForEachWall(~child.index, [&](uint32_t index) {
        least = std::min(least, static_cast<double>(distance(index)));
        return true;
      });
      return least;
    }
    const auto& children = node(child).children;
    const bool second_first = children[1].box.Distance(box) < children[0].box.Distance(box);
    least = Least(children[second_first], box, least, distance);
    return Least(children[!second_first], box, least, distance);
  }

  std::vector<Segment> segments_;
  std::vector<Node> nodes_;
  std::vector<Leaf> leaves_;      // none in a large tree
  std::vector<Indices> indices_;  // of the walls of each leaf
  Child root_;
};

}  // namespace flatland
