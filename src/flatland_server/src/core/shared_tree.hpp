#pragma once

/// Box2D's tree of bounding boxes, for many states of one world.
///
/// Need. The tree has a leaf for each wall, half a megabyte in an office. A body that moves changes
/// some ten nodes of it: its leaf, and others on the way to the root. Environments share the rest.
///
/// Method. A state keeps the nodes that differ from the tree of the beginning. They are written to
/// the tree before a step, and after it those of the beginning are put back. Which nodes a step has
/// changed, Box2D does not tell. So the tree is compared with a copy of what it was before, near
/// the places where Box2D may have written: shared_tree.cpp says which these are.

#include <box2d/box2d.h>

#include <cstdint>
#include <vector>

namespace flatland {

/// A node that is not as at the beginning.
struct TreeChange {
  int32 index;
  b2TreeNode node;
};

class SharedTree {
 public:
  /// Number of nodes of a tree, used or not, up to the last one that a state of the world may use.
  static size_t CountNodes(b2World& world);

  /// Takes the tree of a world to which nothing is added any more, and of which only these fixtures
  /// are ever moved. `changes` becomes what the tree differs by from the beginning already: marks
  /// of leaves that were moved.
  SharedTree(b2World& world, const std::vector<b2Fixture*>& moving,
             std::vector<TreeChange>& changes);
  ~SharedTree();
  SharedTree(const SharedTree&) = delete;
  SharedTree& operator=(const SharedTree&) = delete;

  /// Tells the processor to fetch the nodes that Enter writes to, and Leave reads.
  void Prefetch(const std::vector<TreeChange>& changes) const;
  /// Puts the tree of the beginning, in the world, into a state, until Leave, on the same thread.
  /// The rest of the b2DynamicTree, such as the index of the root, is that of the state already.
  void Enter(const std::vector<TreeChange>& changes);
  /// Replaces `changes` by what the tree differs by, and puts back that of the beginning.
  void Leave(std::vector<TreeChange>& changes);
  /// Number of times that all nodes were compared, since it was not clear what was moved; for
  /// tests.
  int comparisons() const { return comparisons_; }

 private:
  template <class Shape>
  class Observed;
  static void Observe(b2Fixture& fixture);

  /// Of a node. The two are needed together.
  struct Former {
    b2TreeNode before;     // as it was before the move that is followed
    b2TreeNode beginning;  // as at the beginning
  };

  /// Finds out what the moves of leaves since the last call have changed.
  void Follow();
  void FollowMove(int32 leaf);
  void CompareAll();
  /// Compares a node, and those at most `levels` below it.
  void Compare(int32 index, int levels);
  /// Compares a node, its ancestors, and what is at most `levels` below these.
  void CompareAncestors(int32 index, int levels);
  void TakeFound();
  size_t size() const { return former_.size(); }

  static thread_local SharedTree* entered_;

  b2World& world_;
  b2TreeNode* const nodes_;  // those that Box2D uses
  std::vector<int32> moving_leaves_;
  std::vector<Former> former_;
  std::vector<int32> changed_;            // indices of nodes that may differ from the beginning
  std::vector<std::uint8_t> is_changed_;  // of each node, whether it is among them
  std::vector<int32> found_;              // by the present comparison
  int32 insertions_ = 0;                  // into the tree, as far as they were followed
  int comparisons_ = 0;
};

}  // namespace flatland
