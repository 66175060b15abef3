#include "world/layers.hpp"

#include <algorithm>
#include <utility>

#include "base/box2d_internals.hpp"
#include "base/box2d_limits.hpp"
#include "base/to_box2d.hpp"
#include "sight/visible_fixture.hpp"

namespace flatland {
namespace {

/// For the skin of shapes, and for rounding [m].
constexpr float kSkin = 0.05f;

/// Greatest distance of a body's fixtures from its centre of mass [m], and the layers that they
/// collide with.
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

/// Distance of a body from where its walls were looked up, along the axis where it is greater.
float DistanceMoved(const BodyRecord& record) {
  const b2Vec2 way = b2Abs(record.body->GetWorldCenter() - record.nearby.center);
  return std::max(way.x, way.y);
}

/// True for awake dynamic bodies. Sleeping ones keep their walls; others do not collide with walls.
bool MayReachWalls(const BodyRecord& record) {
  return record.body->IsAwake() && record.body->GetType() == b2_dynamicBody;
}

}  // namespace

void RequireWalls(const std::vector<Segment>& walls) {
  for (const Segment& wall : walls) {
    RequirePosition(wall.a);
    RequirePosition(wall.b);
    Require(wall.a.x != wall.b.x || wall.a.y != wall.b.y, "a wall's ends must not be one point");
  }
}

void Layers::CopyFrom(const Layers& other) {
  for (const auto& each : other.all_) all_.push_back(std::make_unique<NearbyWalls>(*each));
}

Bodies::Body Layers::Add(b2World& world, std::vector<Segment> walls, LayerBits bits,
                         const std::function<void(std::size_t added)>& progress) {
  const b2BodyDef definition;
  BodyRecord record;
  record.body = world.CreateBody(&definition);
  record.is_layer = true;
  record.layer = static_cast<uint32_t>(all_.size());
  record.may_move = false;
  auto visible = VisibleWalls::Share(std::move(walls), progress);
  const Bodies::Body handle = bodies_.Add(std::move(record));
  all_.push_back(std::make_unique<NearbyWalls>(std::move(visible), bits, handle.index));
  bodies_.ForEach([](auto, BodyRecord& each) { each.nearby.is_current = false; });
  return handle;
}

int Layers::held_body_count() const {
  int count = 0;
  for (const auto& each : all_) count += each->held_block_count();
  return count;
}

int Layers::held_wall_count() const {
  std::vector<b2Fixture*> fixtures;
  AppendHeldFixtures(fixtures);
  return static_cast<int>(fixtures.size());
}

size_t Layers::FixtureCountOf(const BodyRecord& record) const {
  return record.is_layer ? all_[record.layer]->size() : record.fixtures.size();
}

b2Fixture* Layers::FixtureOrNull(const BodyRecord& record, uint32_t index) const {
  return record.is_layer ? all_[record.layer]->Find(index) : record.fixtures[index].fixture;
}

void Layers::HoldWallsNearBodies(b2World& world, float dt) {
  if (all_.empty()) return;
  for (BodyRecord* const record : bodies_.Moving()) {
    if (!MayReachWalls(*record)) continue;
    const float step = std::min(record->body->GetLinearVelocity().Length() * dt, b2_maxTranslation);
    if (record->nearby.is_current && DistanceMoved(*record) + step <= record->nearby.room) continue;
    const b2Vec2 center = record->body->GetWorldCenter();
    HoldWallsNear(world, *record, {center, center}, room_ + step);
  }
}

bool Layers::HoldWallsOnTheWay(b2World& world) {
  if (all_.empty()) return false;
  bool has_come_far = false;
  for (BodyRecord* const record : bodies_.Moving()) {
    const BodyRecord::Nearby& nearby = record->nearby;
    const bool has_left = !nearby.is_current || DistanceMoved(*record) > nearby.room;  // not if NaN
    if (!MayReachWalls(*record) || !has_left) continue;
    const b2Sweep& sweep = box2d::Sweep(*record->body);
    HoldWallsNear(world, *record, {b2Min(sweep.c0, sweep.c), b2Max(sweep.c0, sweep.c)}, room_);
    has_come_far = true;
  }
  return has_come_far;
}

void Layers::HoldWallsNear(b2World& world, BodyRecord& record, const b2AABB& centers, float room) {
  const Reach reach(record);
  const double size = double{reach.radius} + room + kSkin;
  const Box box{{centers.lowerBound.x - size, centers.lowerBound.y - size},
                {centers.upperBound.x + size, centers.upperBound.y + size}};
  BodyRecord::Nearby nearby{true, record.body->GetWorldCenter(), room, {}};
  const int32 moves = box2d::MoveCount(world);
  for (uint32_t i = 0; i < all_.size(); ++i) {
    if ((all_[i]->layers() & reach.layers) == 0) continue;
    all_[i]->ForEachBlockAt(box, [&](uint32_t number) { nearby.blocks.push_back({i, number}); });
  }
  HoldWallsOf(world, record, std::move(nearby));
  // Box2D searches the new contacts from the body, instead of from each wall.
  box2d::SkipPairsOfNewFixtures(world, moves);
  box2d::FindPairsAgain(*record.body);
}

void Layers::HoldWallsOf(b2World& world, BodyRecord& record, BodyRecord::Nearby nearby) {
  for (const auto& [layer, number] : nearby.blocks) all_[layer]->Hold(world, number);
  for (const auto& [layer, number] : record.nearby.blocks) all_[layer]->Release(world, number);
  record.nearby = std::move(nearby);
}

void Layers::AppendHeldFixtures(std::vector<b2Fixture*>& fixtures) const {
  for (const auto& each : all_) each->AppendFixtures(fixtures);
}

}  // namespace flatland
