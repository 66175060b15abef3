#pragma once

/// Box2D's tree of bounding boxes in a saved state.
///
/// The tree depends on all moves since the beginning, and decides in which order Box2D finds
/// contacts, hence solves them. A world that is to go on bit for bit has to have the same tree.

#include <box2d/box2d.h>

#include <vector>

namespace flatland {

struct SavedTree {
  /// A node, without pointers, which differ between worlds.
  struct Node {
    b2AABB box{b2Vec2_zero, b2Vec2_zero};  // Box2D's constructors leave the memory as it was
    int32 parent = b2_nullNode;            // in a free node: the next free one
    int32 child1 = b2_nullNode;
    int32 child2 = b2_nullNode;  // of a leaf: the number of its fixture
    int32 height = 0;            // in a free node: -1
    bool moved = false;

    bool is_leaf() const { return height == 0; }
    template <class Archive>
    void Serialize(Archive& archive) {
      archive(box.lowerBound, box.upperBound, parent, child1, child2, height, moved);
    }
  };

  /// The present tree of a world with these fixtures.
  static SavedTree Of(b2World& world, const std::vector<b2Fixture*>& fixtures);
  /// Replaces the tree of a world with these fixtures.
  void Restore(b2World& world, const std::vector<b2Fixture*>& fixtures) const;
  /// True if this is a valid tree with a leaf for each of `fixtures` fixtures.
  bool IsSound(size_t fixture_count) const;
  int32 node_count() const { return static_cast<int32>(nodes.size()); }

  template <class Archive>
  void Serialize(Archive& archive) {
    archive(root, first_free, nodes, moves);
  }

  int32 root = b2_nullNode;
  int32 first_free = 0;      // node_count(): the first one that was never in use
  std::vector<Node> nodes;   // up to the last one that was ever in use
  std::vector<int32> moves;  // proxies that may have new contacts
};

}  // namespace flatland
