#pragma once

/// Static walls, indexed once for lidars.
///
/// A binary tree of boxes. Each node's walls are split in two where the two boxes are smallest for
/// what they hold (the surface area heuristic: MacDonald and Booth, "Heuristics for Ray Tracing
/// Using Space Subdivision", 1990; here with perimeters), until a handful of walls is left. How it
/// is looked at is the matter of `DepthBuffer`.

#include <cstdint>
#include <memory>
#include <vector>

#include "flatland_server/geometry.hpp"

namespace flatland {

/// A rectangle along the axes, borders included; one that holds nothing has its corners swapped.
struct Box {
  Vec2 low{1e300, 1e300};
  Vec2 high{-1e300, -1e300};

  void Add(const Segment& segment);
  void Add(const Box& other);
  double half_perimeter() const { return high.x - low.x + high.y - low.y; }
};

class SegmentTree {
 public:
  static constexpr int kLeafSize = 8;
  /// No path from the root is longer than this.
  static constexpr int kMostDepth = 96;

  /// A few walls from (ax, ay) to (bx, by), coordinate by coordinate, to be handled several at a
  /// time. Where there are fewer, the rest is not a number.
  struct Leaf {
    double ax[kLeafSize];
    double ay[kLeafSize];
    double bx[kLeafSize];
    double by[kLeafSize];
  };

  struct Child {
    Box box;
    /// Its place among the nodes, or the complement (~) of its place among the leaves.
    int32_t index = 0;
    bool is_leaf() const { return index < 0; }
  };

  struct Node {
    Child children[2];
  };

  explicit SegmentTree(const std::vector<Segment>& segments);

  /// The tree of these segments that somebody uses already, or a new one: a thousand worlds with
  /// one map need it once.
  static std::shared_ptr<const SegmentTree> Share(const std::vector<Segment>& segments);

  size_t segment_count() const { return segments_.size(); }
  /// All of it, as if it were a node's child. An empty tree has an empty box.
  const Child& root() const { return root_; }
  const Node& node(const Child& child) const { return nodes_[child.index]; }
  const Leaf& leaf(const Child& child) const { return leaves_[~child.index]; }

 private:
  using Iterator = std::vector<uint32_t>::iterator;

  Child Build(Iterator begin, Iterator end, int depth);
  Iterator Split(Iterator begin, Iterator end, int depth);
  int32_t AddLeaf(Iterator begin, Iterator end);

  std::vector<Segment> segments_;
  std::vector<Node> nodes_;
  std::vector<Leaf> leaves_;
  Child root_;
};

}  // namespace flatland
