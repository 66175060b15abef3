#pragma once

/// A search tree over the static walls of a layer, for lidars.
///
/// A binary tree of bounding boxes, built once. The walls of a node are divided between two
/// children such that their boxes are small for the number of walls in them (the surface area
/// heuristic: MacDonald and Booth, "Heuristics for Ray Tracing Using Space Subdivision", 1990; here
/// with perimeters). A leaf holds up to kLeafSize walls. DepthBuffer traverses the tree.

#include <algorithm>
#include <array>
#include <cstdint>
#include <memory>
#include <vector>

#include "flatland_server/geometry.hpp"

namespace flatland {

/// An axis-aligned bounding box [m]. Initially empty, with low above high.
struct Box {
  Vec2 low{1e300, 1e300};
  Vec2 high{-1e300, -1e300};

  void Add(const Segment& segment);
  void Add(const Box& other);
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

  explicit SegmentTree(const std::vector<Segment>& segments);

  /// An existing tree of equal segments, or a new one. So all worlds with the same map share one.
  static std::shared_ptr<const SegmentTree> Share(const std::vector<Segment>& segments);

  size_t segment_count() const { return segments_.size(); }
  const std::vector<Segment>& segments() const { return segments_; }
  /// The whole tree, in the form of a node's child. The box of an empty tree is empty.
  const Child& root() const { return root_; }
  const Node& node(const Child& child) const { return nodes_[child.index]; }
  const Leaf& leaf(const Child& child) const { return leaves_[~child.index]; }
  /// The indices in segments() of a leaf's walls, by their places in it.
  const std::array<uint32_t, kLeafSize>& indices(const Child& child) const {
    return indices_[~child.index];
  }

 private:
  using Iterator = std::vector<uint32_t>::iterator;

  Child Build(Iterator begin, Iterator end, int depth);
  Iterator Split(Iterator begin, Iterator end, int depth);
  int32_t AddLeaf(Iterator begin, Iterator end);

  std::vector<Segment> segments_;
  std::vector<Node> nodes_;
  std::vector<Leaf> leaves_;
  std::vector<std::array<uint32_t, kLeafSize>> indices_;  // of the walls of each leaf
  Child root_;
};

}  // namespace flatland
