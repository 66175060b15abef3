#pragma once

/// The walls of a very large layer, of which Box2D has those near dynamic bodies.
///
/// Need. A wall takes about 400 bytes in Box2D: a fixture with its shape, and nodes of the tree of
/// bounding boxes. With the four million walls of a large and noisy map that is 2 GB, and robots
/// touch a few hundred of them.
///
/// Method. The lidars' tree (SegmentTree) has all walls. Its leaves, in their order, are divided
/// into blocks of eight: up to 64 walls that are close together. Before each step, World holds the
/// blocks near each dynamic body. A block that is held has a static body in Box2D, with a fixture
/// for each of its walls; it is destroyed when it is released as often as it was held.

#include <box2d/box2d.h>

#include <cstdint>
#include <memory>
#include <set>
#include <unordered_map>
#include <vector>

#include "flatland_server/collision_layers.hpp"
#include "flatland_server/segment_tree.hpp"
#include "world_state.hpp"

namespace flatland {

b2EdgeShape EdgeOf(const Segment& wall);

/// Makes the fixture of a wall, with this index in its layer.
b2Fixture* AddWall(b2Body& body, const Segment& wall, uint32_t index, LayerBits layers,
                   const Material& material);

class NearbyWalls {
 public:
  /// `owner` is the user data of the bodies that are made.
  NearbyWalls(std::shared_ptr<const SegmentTree> walls, LayerBits layers, uint32_t owner)
      : walls_(std::move(walls)), layers_(layers), owner_(owner) {}

  const SegmentTree& walls() const { return *walls_; }
  size_t size() const { return walls_->segment_count(); }
  LayerBits layers() const { return layers_; }
  uint32_t owner() const { return owner_; }

  /// Blocks with walls near a box [m], in ascending order, and perhaps more.
  std::vector<uint32_t> BlocksAt(const Box& box) const;
  void Hold(b2World& world, const std::vector<uint32_t>& blocks);
  void Release(b2World& world, const std::vector<uint32_t>& blocks);
  /// Forgets what was held, when its b2World is no more.
  void Clear() { held_.clear(); }
  /// The bodies of the blocks that are held, by the numbers of the blocks.
  std::vector<b2Body*> HeldBodies() const;
  bool IsBlock(uint32_t number) const;
  /// Number of walls of some blocks.
  size_t CountWalls(const std::set<uint32_t>& blocks) const;
  int held_count() const { return static_cast<int>(held_.size()); }
  int held_wall_count() const { return static_cast<int>(CountWalls(HeldBlocks())); }
  /// The fixture of a wall, or null if its block is not held.
  b2Fixture* Find(uint32_t wall) const;

  /// True if a fixture overlaps a wall, by `overlap(shape, transform)`.
  template <class Overlap>
  bool Overlaps(const b2AABB& bounds, Overlap overlap) const;

  const Material& GetMaterial(uint32_t wall) const;
  /// Of a wall, whether its block is held or not.
  void SetMaterial(uint32_t wall, const Material& material);
  /// Of all walls, or a single one if all have that.
  std::vector<Material> GetMaterials() const;
  void SetMaterials(const std::vector<Material>& materials);

 private:
  struct Block {
    b2Body* body = nullptr;
    int holders = 0;
  };

  std::set<uint32_t> HeldBlocks() const;
  /// Calls `visit(index)` for each wall of a block.
  template <class Visit>
  void ForEachWall(uint32_t block, Visit visit) const;

  std::shared_ptr<const SegmentTree> walls_;
  LayerBits layers_;
  uint32_t owner_;
  std::unordered_map<uint32_t, Block> held_;  // by their numbers
  Material material_ = kDefaultMaterial;      // of walls that are not in `changed_`
  std::unordered_map<uint32_t, Material> changed_;
};

template <class Overlap>
bool NearbyWalls::Overlaps(const b2AABB& bounds, Overlap overlap) const {
  b2Transform origin;
  origin.SetIdentity();
  bool overlaps = false;
  const Box box{{bounds.lowerBound.x, bounds.lowerBound.y},
                {bounds.upperBound.x, bounds.upperBound.y}};
  walls_->ForEachLeafAt(box, [&](size_t leaf) {
    if (overlaps) return;
    walls_->ForEachWall(leaf, [&](uint32_t index) {
      overlaps = overlaps || overlap(EdgeOf(walls_->segments()[index]), origin);
    });
  });
  return overlaps;
}

}  // namespace flatland
