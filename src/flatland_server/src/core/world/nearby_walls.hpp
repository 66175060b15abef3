#pragma once

/// The walls of a layer, of which Box2D has those near dynamic bodies.
///
/// Need. A wall takes about 400 bytes and half a microsecond in Box2D: a fixture with its shape,
/// and nodes of the tree of bounding boxes. An office has 5,000 of them, and a noisy map four
/// million, of which a robot may touch a few in its next step.
///
/// Method. The lidars' tree (SegmentTree) has all walls. Each of its leaves is a block: up to eight
/// walls that are close together. Layers holds the blocks near each dynamic body. A block that is
/// held has a static body in Box2D, with a fixture for each of its walls; it is destroyed when it
/// is released as often as it was held.

#include <box2d/box2d.h>

#include <cstdint>
#include <memory>
#include <unordered_map>
#include <vector>

#include "base/collision_layers.hpp"
#include "sight/visible_walls.hpp"
#include "world/world_state.hpp"

namespace flatland {

b2EdgeShape EdgeOf(const Segment& wall);

class NearbyWalls {
 public:
  struct Block {
    uint32_t number = 0;
    int holders = 0;
    b2Body* body = nullptr;
  };
  /// The blocks that are held, in the order of their numbers.
  using Held = std::vector<Block>;

  /// `owner` is the user data of the bodies that are made.
  NearbyWalls(std::shared_ptr<const VisibleWalls> walls, LayerBits layers, uint32_t owner)
      : visible_(std::move(walls)), layers_(layers), owner_(owner) {}
  /// Copies the walls and materials for another Box2D world, which holds none of them yet.
  NearbyWalls(const NearbyWalls& other)
      : visible_(other.visible_),
        layers_(other.layers_),
        owner_(other.owner_),
        material_(other.material_),
        changed_(other.changed_) {}
  NearbyWalls& operator=(const NearbyWalls&) = delete;

  const SegmentTree& walls() const { return visible_->all(); }
  /// The same walls, for lidars.
  const VisibleWalls& visible() const { return *visible_; }
  size_t size() const { return walls().segment_count(); }
  LayerBits layers() const { return layers_; }
  uint32_t owner() const { return owner_; }

  /// Calls `visit(block)`, in ascending order, for the blocks with a wall that has a bounding
  /// box which overlaps `box` [m].
  template <class Visit>
  void ForEachBlockAt(const Box& box, Visit visit) const {
    walls().ForEachLeafAt(box, [&](size_t leaf) {
      bool is_near = false;
      walls().ForEachWall(leaf, [&](uint32_t index) {
        Box wall;
        wall.Add(walls().segments()[index]);
        is_near = is_near || wall.Meets(box);
      });
      if (is_near) visit(static_cast<uint32_t>(leaf));
    });
  }
  bool IsBlock(uint32_t number) const { return number < walls().leaf_count(); }
  size_t CountWalls(uint32_t block) const;
  void Hold(b2World& world, uint32_t block);
  void Release(b2World& world, uint32_t block);
  /// Appends the fixtures of the blocks that are held. Their order depends on nothing but which
  /// blocks are held.
  void AppendFixtures(std::vector<b2Fixture*>& fixtures) const;
  /// Exchanges what is held with that of another state of the world.
  void Exchange(Held& held) { held_.swap(held); }
  /// Exchanges the walls. None must be held, and all must have the same material.
  void ExchangeWalls(std::shared_ptr<const VisibleWalls>& walls) { visible_.swap(walls); }
  bool IsAtBeginning() const { return held_.empty() && changed_.empty(); }
  int held_block_count() const { return static_cast<int>(held_.size()); }
  /// The fixture of a wall, or null if its block is not held.
  b2Fixture* Find(uint32_t wall);

  /// True if a fixture overlaps a wall, by `overlap(shape, transform)`.
  template <class Overlap>
  bool Overlaps(const b2AABB& bounds, Overlap overlap) const;

  const Material& GetMaterial(uint32_t wall) const;
  /// Material of a wall, whether its block is held or not.
  void SetMaterial(uint32_t wall, const Material& material);
  /// Materials of all walls, or a single one if all have the same.
  std::vector<Material> GetMaterials() const;
  void SetMaterials(const std::vector<Material>& materials);

 private:
  /// Gives a wall's fixture its material.
  void Apply(b2Fixture& wall) const;
  /// The position of a block in `held_`, or where it would be inserted.
  Held::iterator Place(uint32_t number);

  std::shared_ptr<const VisibleWalls> visible_;
  LayerBits layers_;
  uint32_t owner_;
  Held held_;
  Material material_ = kDefaultMaterial;  // of walls that are not in `changed_`
  std::unordered_map<uint32_t, Material> changed_;
};

template <class Overlap>
bool NearbyWalls::Overlaps(const b2AABB& bounds, Overlap overlap) const {
  b2Transform origin;
  origin.SetIdentity();
  bool overlaps = false;
  const Box box{{bounds.lowerBound.x, bounds.lowerBound.y},
                {bounds.upperBound.x, bounds.upperBound.y}};
  walls().ForEachLeafAt(box, [&](size_t leaf) {
    if (overlaps) return;
    walls().ForEachWall(leaf, [&](uint32_t index) {
      overlaps = overlaps || overlap(EdgeOf(walls().segments()[index]), origin);
    });
  });
  return overlaps;
}

}  // namespace flatland
