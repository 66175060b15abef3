#pragma once

/// The layers of a world: their walls for lidars, and those near dynamic bodies in Box2D.
///
/// In Box2D, a body may move by up to b2_maxTranslation in a step, but few do. So Box2D is given
/// the walls that a body will reach at its present velocity, and some room beyond. If a step has
/// taken a body farther, as after a collision, Box2D is given the walls along its path, and the
/// step goes on: Box2D looks for times of impact after it has moved everything, and can do so
/// again.

#include <box2d/box2d.h>

#include <cstddef>
#include <functional>
#include <memory>
#include <vector>

#include "base/collision_layers.hpp"
#include "base/geometry.hpp"
#include "world/bodies.hpp"
#include "world/nearby_walls.hpp"

namespace flatland {

/// Throws std::invalid_argument for a wall that is too short or too far away.
void RequireWalls(const std::vector<Segment>& walls);

class Layers {
 public:
  /// Box2D has the walls that are up to `room` [m] beyond what a body will reach. The world's
  /// bodies must live as long.
  Layers(Bodies& bodies, float room) : bodies_(bodies), room_(room) {}
  Layers(const Layers&) = delete;
  Layers& operator=(const Layers&) = delete;
  /// Copies the layers of an equal world. Box2D must have no walls yet.
  void CopyFrom(const Layers& other);

  float room() const { return room_; }

  /// See World::AddLayer.
  Bodies::Body Add(b2World& world, std::vector<Segment> walls, LayerBits bits,
                   const std::function<void(std::size_t added)>& progress);
  const std::vector<std::unique_ptr<NearbyWalls>>& all() const { return all_; }
  /// The walls of a layer in Box2D, or null if the record is no layer.
  NearbyWalls* NearbyOf(const BodyRecord& record) const {
    return record.is_layer ? all_[record.layer].get() : nullptr;
  }
  /// The number of a body's fixtures, or of a layer's walls.
  std::size_t FixtureCountOf(const BodyRecord& record) const;
  /// A fixture of a body, or null for a wall that Box2D does not have at present.
  b2Fixture* FixtureOrNull(const BodyRecord& record, uint32_t index) const;

  /// Makes sure that Box2D has the walls that dynamic bodies will reach in a step of `dt` [s].
  void HoldWallsNearBodies(b2World& world, float dt);
  /// Makes sure that Box2D has the walls along the paths of dynamic bodies in the last step.
  /// Returns true if it got walls, and has to look for times of impact with them.
  bool HoldWallsOnTheWay(b2World& world);
  /// Gives Box2D the walls in `nearby` for a body, in place of those that it had for it.
  void HoldWallsOf(b2World& world, BodyRecord& record, BodyRecord::Nearby nearby);
  void ReleaseWallsNear(b2World& world, BodyRecord& record) { HoldWallsOf(world, record, {}); }
  /// Appends the fixtures of the walls that Box2D has. Their order depends only on which walls
  /// these are.
  void AppendHeldFixtures(std::vector<b2Fixture*>& fixtures) const;
  /// The number of Box2D's bodies for walls near bodies.
  int held_body_count() const;
  int held_wall_count() const;

 private:
  /// Gives Box2D the walls that a body reaches if its centre is in a box, and those in some room
  /// beyond.
  void HoldWallsNear(b2World& world, BodyRecord& record, const b2AABB& centers, float room);

  Bodies& bodies_;
  float room_;  // [m]
  std::vector<std::unique_ptr<NearbyWalls>> all_;
};

}  // namespace flatland
