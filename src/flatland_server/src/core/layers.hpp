#pragma once

/// The layers of a world: their walls for lidars, and in Box2D. Of large layers, Box2D has the
/// walls near dynamic bodies alone (nearby_walls.hpp).

#include <box2d/box2d.h>

#include <cstddef>
#include <functional>
#include <memory>
#include <vector>

#include "flatland_server/bodies.hpp"
#include "flatland_server/collision_layers.hpp"
#include "flatland_server/geometry.hpp"
#include "flatland_server/segment_tree.hpp"
#include "nearby_walls.hpp"

namespace flatland {

class Layers {
 public:
  struct Layer {
    std::shared_ptr<const SegmentTree> walls;
    LayerBits bits;
  };

  /// Layers of more than `large` walls are large. The world's bodies must live as long.
  Layers(Bodies& bodies, std::size_t large) : bodies_(bodies), large_(large) {}
  Layers(const Layers&) = delete;
  Layers& operator=(const Layers&) = delete;
  /// Takes the walls of an equal world, for lidars. None of the layers is large.
  void CopyFrom(const Layers& other) { all_ = other.all_; }

  /// Takes the first `count` layers of another world, as they were at first. That keeps none.
  void TakeFrom(Layers& other, std::size_t count);
  /// True if the first layers are these.
  bool BeginWith(const std::vector<Layer>& layers) const;

  /// See World::AddLayer.
  Bodies::Body Add(b2World& world, std::vector<Segment> walls, LayerBits bits,
                   const std::function<void(std::size_t added)>& progress);
  /// True if the world has no other bodies.
  bool AreAlone(const b2World& world) const {
    return world.GetBodyCount() - held_body_count() == static_cast<int>(all_.size());
  }
  const std::vector<Layer>& all() const { return all_; }
  const std::vector<std::unique_ptr<NearbyWalls>>& large_layers() const { return large_layers_; }
  /// The large layer of a record, or null.
  NearbyWalls* LargeLayerOf(const BodyRecord& record) const;
  /// The number of a body's fixtures, or of a layer's walls.
  std::size_t FixtureCountOf(const BodyRecord& record) const;
  /// A fixture of a body, or null for a wall that Box2D does not have at present.
  b2Fixture* FixtureOrNull(const BodyRecord& record, uint32_t index) const;

  /// Makes sure that Box2D has all walls that a dynamic body may reach in the next step.
  void HoldWallsNearBodies(b2World& world);
  void ReleaseWallsNear(b2World& world, BodyRecord& record);
  /// Makes Box2D have the walls of large layers that `nearby` names, for a record without any.
  void HoldWallsOf(b2World& world, BodyRecord& record, BodyRecord::Nearby nearby);
  /// The fixtures of the walls of large layers that Box2D has, in an order that depends on which
  /// these are alone.
  void AppendHeldFixtures(std::vector<b2Fixture*>& fixtures) const;
  /// The number of Box2D's bodies for walls near bodies.
  int held_body_count() const;
  int held_wall_count() const;

 private:
  void HoldWallsNear(b2World& world, BodyRecord& record);

  Bodies& bodies_;
  std::size_t large_;
  std::vector<Layer> all_;
  std::vector<std::unique_ptr<NearbyWalls>> large_layers_;
};

}  // namespace flatland
