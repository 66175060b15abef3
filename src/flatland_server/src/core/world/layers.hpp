#pragma once

/// The layers of a world: their walls for lidars, and those near dynamic bodies in Box2D.
///
/// A body of Box2D's moves up to b2_maxTranslation in a step, but few do. So it has the walls that
/// a body will reach at its present velocity, and some room beyond. When a step has taken a body
/// farther, as after a collision, Box2D gets the walls along its way, and the step goes on: Box2D
/// looks for times of impact after it has moved everything, and can do so again.

#include <box2d/box2d.h>

#include <cstddef>
#include <functional>
#include <memory>
#include <vector>

#include "base/collision_layers.hpp"
#include "base/geometry.hpp"
#include "sight/visible_walls.hpp"
#include "world/bodies.hpp"
#include "world/nearby_walls.hpp"

namespace flatland {

/// Throws std::invalid_argument for a wall that is none, or too far away.
void RequireWalls(const std::vector<Segment>& walls);

class Layers {
 public:
  struct Layer {
    const SegmentTree& walls() const { return visible->all(); }

    std::shared_ptr<const VisibleWalls> visible;
    LayerBits bits;
  };

  /// Box2D has the walls that are up to `room` [m] beyond what a body will reach. The world's
  /// bodies must live as long.
  Layers(Bodies& bodies, float room) : bodies_(bodies), room_(room) {}
  Layers(const Layers&) = delete;
  Layers& operator=(const Layers&) = delete;
  /// Takes the layers of an equal world, of which Box2D has no walls yet.
  void CopyFrom(const Layers& other);

  float room() const { return room_; }

  /// See World::AddLayer.
  Bodies::Body Add(b2World& world, std::vector<Segment> walls, LayerBits bits,
                   const std::function<void(std::size_t added)>& progress);
  const std::vector<Layer>& all() const { return all_; }
  /// Exchanges the walls of the first layer with others, while Box2D has none of either.
  void ExchangeFirst(std::shared_ptr<const VisibleWalls>& walls);
  /// The walls of all layers in Box2D, in the same order.
  const std::vector<std::unique_ptr<NearbyWalls>>& nearby() const { return nearby_; }
  /// Those of a record, or null if it is no layer.
  NearbyWalls* NearbyOf(const BodyRecord& record) const {
    return record.is_layer ? nearby_[record.layer].get() : nullptr;
  }
  /// The number of a body's fixtures, or of a layer's walls.
  std::size_t FixtureCountOf(const BodyRecord& record) const;
  /// A fixture of a body, or null for a wall that Box2D does not have at present.
  b2Fixture* FixtureOrNull(const BodyRecord& record, uint32_t index) const;

  /// Makes sure that Box2D has the walls that dynamic bodies will reach in a step of `dt` [s].
  void HoldWallsNearBodies(b2World& world, float dt);
  /// The same for those that bodies have come to in the last step, on the way that they have made.
  /// Returns true if Box2D is to look for times of impact with these.
  bool HoldWallsOnTheWay(b2World& world);
  /// Makes Box2D have the walls that are named, and not those that the record had.
  void HoldWallsOf(b2World& world, BodyRecord& record, BodyRecord::Nearby nearby);
  void ReleaseWallsNear(b2World& world, BodyRecord& record) { HoldWallsOf(world, record, {}); }
  /// The fixtures of the walls that Box2D has, in an order that depends on which these are alone.
  void AppendHeldFixtures(std::vector<b2Fixture*>& fixtures) const;
  /// The number of Box2D's bodies for walls near bodies.
  int held_body_count() const;
  int held_wall_count() const;

 private:
  /// Lets Box2D have the walls of a box that a body is in, with some room.
  void HoldWallsNear(b2World& world, BodyRecord& record, const b2AABB& centers, float room);

  Bodies& bodies_;
  float room_;  // [m]
  std::vector<Layer> all_;
  std::vector<std::unique_ptr<NearbyWalls>> nearby_;
};

}  // namespace flatland
