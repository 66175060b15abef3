/// World: layers, and which of their walls Box2D has.

#include <algorithm>

#include "box2d_internals.hpp"
#include "box2d_limits.hpp"
#include "flatland_server/world.hpp"
#include "nearby_walls.hpp"
#include "to_box2d.hpp"

namespace flatland {
namespace {

/// How far a body moves before the walls near it are looked up again [m].
constexpr float kSlack = 0.5f;
/// Walls within this of a body's reach are near it [m]. In a step, Box2D moves no body farther than
/// b2_maxTranslation; the rest is for the skin of shapes, and for rounding.
constexpr float kNear = b2_maxTranslation + kSlack + 0.2f;

/// How far a body's fixtures reach from its centre of mass, however it is turned [m], and the
/// layers that they collide with.
struct Reach {
  explicit Reach(const BodyRecord& record) {
    const b2Vec2 center = record.body->GetLocalCenter();
    for (const BodyRecord::FixtureRecord& each : record.fixtures) {
      const b2Vec2 arm = CentroidOf(*each.fixture->GetShape()) - center;
      radius = std::max(
          radius, arm.Length() + static_cast<float>(BoundingRadius(*each.fixture->GetShape())));
      layers |= each.fixture->GetFilterData().maskBits;
    }
  }

  float radius = 0.0f;
  LayerBits layers = 0;
};

}  // namespace

World::Body World::AddLayer(std::vector<Segment> walls, LayerBits layers,
                            const std::function<void(std::size_t added)>& progress) {
  for (const Segment& wall : walls) {
    RequirePosition(wall.a);
    RequirePosition(wall.b);
    Require(wall.a.x != wall.b.x || wall.a.y != wall.b.y, "a wall's ends must not be one point");
  }
  const AccessGuard guard(*this);
  const b2BodyDef definition;
  BodyRecord record;
  record.body = world_->CreateBody(&definition);
  record.is_layer = true;
  record.may_move = false;
  const bool is_large = walls.size() > large_layer_;
  if (is_large) {
    record.large_layer = static_cast<int>(large_layers_.size());
    layers_.push_back({VisibleWalls::Share(std::move(walls), progress), layers});
  } else {
    record.fixtures.reserve(walls.size());
    for (const Segment& wall : walls) {
      const auto index = static_cast<uint32_t>(record.fixtures.size());
      record.fixtures.push_back(
          {AddWall(*record.body, wall, index, layers, kDefaultMaterial), false, 0.0});
      const size_t added = record.fixtures.size();
      const bool is_due = added % SegmentTree::kProgressStep == 0 || added == walls.size();
      if (progress && is_due) progress(added);
    }
    layers_.push_back({VisibleWalls::Share(std::move(walls)), layers});
  }
  const bool has_layers_alone = body_count() == static_cast<int>(layers_.size());
  if (has_layers_alone) box2d::SkipPairsOfNewFixtures(*world_);
  const Body handle = AddRecord(std::move(record));
  if (is_large) {
    large_layers_.push_back(
        std::make_shared<NearbyWalls>(layers_.back().walls->shared(), layers, handle.index));
    bodies_.ForEach([](Body, BodyRecord& each) { each.nearby.is_current = false; });
  }
  return handle;
}

int World::body_count() const {
  int count = world_->GetBodyCount();
  for (const auto& each : large_layers_) count -= each->held_count();
  return count;
}

int World::held_wall_count() const {
  int count = 0;
  for (const auto& each : large_layers_) count += each->held_wall_count();
  return count;
}

NearbyWalls* World::LargeLayerOf(const BodyRecord& record) const {
  return record.large_layer < 0 ? nullptr : large_layers_[record.large_layer].get();
}

size_t World::FixtureCountOf(const BodyRecord& record) const {
  const NearbyWalls* large = LargeLayerOf(record);
  return large == nullptr ? record.fixtures.size() : large->size();
}

void World::HoldWallsNearBodies() {
  if (large_layers_.empty()) return;
  bodies_.ForEach([this](Body, BodyRecord& record) {
    if (record.body->GetType() != b2_dynamicBody) return;
    const b2Vec2 way = record.body->GetWorldCenter() - record.nearby.center;
    if (record.nearby.is_current && std::max(std::abs(way.x), std::abs(way.y)) <= kSlack) return;
    HoldWallsNear(record);
  });
}

void World::HoldWallsNear(BodyRecord& record) {
  const Reach reach(record);
  const b2Vec2 center = record.body->GetWorldCenter();
  const double size = double{reach.radius} + kNear;
  const Box box{{center.x - size, center.y - size}, {center.x + size, center.y + size}};
  std::vector<std::vector<uint32_t>> blocks;
  const int32 moves = box2d::MoveCount(*world_);
  for (const auto& layer : large_layers_) {
    const bool collides = (layer->layers() & reach.layers) != 0;
    blocks.push_back(collides ? layer->BlocksAt(box) : std::vector<uint32_t>());
    layer->Hold(*world_, blocks.back());
  }
  // The body looks for the walls: in a large world, it would take long if each wall did.
  box2d::SkipPairsOfNewFixtures(*world_, moves);
  box2d::FindPairsAgain(*record.body);
  ReleaseWallsNear(record);
  record.nearby = {true, center, std::move(blocks)};
}

void World::ReleaseWallsNear(BodyRecord& record) {
  for (size_t i = 0; i < record.nearby.blocks.size(); ++i) {
    large_layers_[i]->Release(*world_, record.nearby.blocks[i]);
  }
  record.nearby = {};
}

void World::ForgetHeldWalls() {
  for (const auto& layer : large_layers_) layer->Clear();
  bodies_.ForEach([](Body, BodyRecord& record) { record.nearby = {}; });
}

b2Fixture* World::FixtureOrNull(const BodyRecord& record, uint32_t index) const {
  const NearbyWalls* large = LargeLayerOf(record);
  return large == nullptr ? record.fixtures[index].fixture : large->Find(index);
}

}  // namespace flatland
