#pragma once

/// Box2D's tree of bounding boxes in a saved state.
///
/// Need. The tree depends on all moves since the beginning, and decides in which order Box2D finds
/// contacts, hence solves them. A world that is to go on bit for bit has to have the same tree; but
/// a tree has a leaf for each wall, half a megabyte in an office.
///
/// Method. The tree as the walls alone make it (WallTree) is the same in each world of these walls.
/// A state has the nodes that differ from it: those of bodies, and those changed by their moves.

#include <box2d/box2d.h>

#include <cstdint>
#include <memory>
#include <vector>

namespace flatland {

/// A node, without what is different in another world.
struct SavedNode {
  b2AABB box{b2Vec2_zero, b2Vec2_zero};  // Box2D's constructors leave the memory as it was
  int32 parent = b2_nullNode;            // of one that is not in use: the next such
  int32 child1 = b2_nullNode;
  int32 child2 = b2_nullNode;  // of a leaf: the number of its fixture
  int32 height = 0;            // of one that is not in use: -1
  bool moved = false;

  bool operator==(const SavedNode& other) const;
  template <class Archive>
  void Serialize(Archive& archive) {
    archive(box.lowerBound, box.upperBound, parent, child1, child2, height, moved);
  }
};

/// The tree of a world with nothing but walls; wall i is fixture i.
class WallTree {
 public:
  /// The box around each wall [m], of each layer.
  using Boxes = std::vector<std::vector<b2AABB>>;

  /// It is not made again if `present`, or the one that was
  /// made last, is of these walls.
  static std::shared_ptr<const WallTree> Of(Boxes boxes,
                                            const std::shared_ptr<const WallTree>& present);
  /// The tree that was made last, if it is of these walls and still in use; otherwise null.
  static std::shared_ptr<const WallTree> Latest(const Boxes& boxes);
  explicit WallTree(Boxes boxes);
  /// Replaces the tree of a world with nothing but these walls, which have these fixtures.
  void PutInto(b2World& world, const std::vector<b2Fixture*>& fixtures) const;

  const std::vector<SavedNode>& nodes() const { return nodes_; }
  /// Of the boxes: another one with other walls.
  uint32_t checksum() const { return checksum_; }

 private:
  bool IsOf(const Boxes& boxes) const;

  Boxes boxes_;
  std::vector<SavedNode> nodes_;
  uint32_t checksum_ = 0;
};

struct SavedTree {
  /// The present tree of a world with these fixtures, of which the first ones are the walls.
  static SavedTree Of(b2World& world, const std::vector<b2Fixture*>& fixtures,
                      const WallTree& walls);
  /// Replaces the tree of a world with these fixtures.
  void Restore(b2World& world, const std::vector<b2Fixture*>& fixtures,
               const WallTree& walls) const;
  /// True if this is a tree with a leaf for each of so many fixtures.
  bool IsSound(size_t fixture_count, const WallTree& walls) const;
  /// Number of nodes up to the last one that was ever in use.
  size_t size() const { return static_cast<size_t>(node_count); }

  template <class Archive>
  void Serialize(Archive& archive) {
    archive(root, first_free, node_count);
    auto count = static_cast<uint32_t>(changes.size());
    archive(count);
    if constexpr (Archive::kIsReader) {
      if (count > archive.remaining() / sizeof(int32)) Archive::Fail();
      changes.assign(count, {});
    }
    for (Change& each : changes) archive(each.index, each.node);
    auto move_count = static_cast<uint32_t>(moves.size());
    archive(move_count);
    if constexpr (Archive::kIsReader) {
      if (move_count > archive.remaining() / sizeof(int32)) Archive::Fail();
      moves.assign(move_count, 0);
    }
    for (int32& each : moves) archive(each);
  }

  struct Change {
    int32 index = 0;
    SavedNode node;
  };

  int32 root = b2_nullNode;
  int32 first_free = 0;  // node_count: the first one that was never in use
  int32 node_count = 0;
  std::vector<Change> changes;
  std::vector<int32> moves;  // proxies that may have new contacts

 private:
  std::vector<SavedNode> Nodes(const WallTree& walls) const;
};

}  // namespace flatland
