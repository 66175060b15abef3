/// World: its walls, used again by another world.

#include <algorithm>
#include <utility>

#include "box2d_internals.hpp"
#include "box2d_limits.hpp"
#include "flatland_server/world.hpp"
#include "layers.hpp"
#include "wall_snapshot.hpp"
#include "world_state.hpp"

namespace flatland {
namespace {

/// The record of a layer as World::AddLayer makes it.
BodyRecord AsNew(BodyRecord record) {
  BodyRecord layer;
  layer.body = record.body;
  layer.is_layer = true;
  layer.large_layer = record.large_layer;
  layer.may_move = false;
  layer.fixtures = std::move(record.fixtures);
  if (!record.has_changed_material) return layer;
  for (const BodyRecord::FixtureRecord& each : layer.fixtures) {
    each.fixture->SetFriction(kDefaultMaterial.friction);
    each.fixture->SetRestitution(kDefaultMaterial.restitution);
  }
  return layer;
}

}  // namespace

void World::RememberLayers() {
  const AccessGuard guard(*this);
  Require(bodies_.size() == layers_->all().size(), "there must be layers alone");
  snapshot_ = std::make_shared<const WallSnapshot>(*world_, layers_->all());
}

bool World::TakeLayers(World& former, const World& equal) {
  const AccessGuard guard(*this), of_former(former), of_equal(equal);
  Require(bodies_.size() == 0, "layers are taken by an empty world");
  const std::shared_ptr<const WallSnapshot> snapshot = equal.snapshot_;
  if (snapshot == nullptr || !former.layers_->BeginWith(snapshot->layers())) return false;
  layers_->TakeFrom(*former.layers_, snapshot->layers().size());
  std::swap(world_, former.world_);
  world_->SetDestructionListener(nullptr);
  world_->SetContactListener(nullptr);
  std::vector<BodyRecord> records = former.RemoveAll();
  records.resize(snapshot->layers().size());
  b2Body* next = nullptr;
  for (b2Body* body = world_->GetBodyList(); body != nullptr; body = next) {
    next = body->GetNext();
    const auto is_its = [&](const BodyRecord& record) { return record.body == body; };
    if (std::none_of(records.begin(), records.end(), is_its)) world_->DestroyBody(body);
  }
  for (BodyRecord& record : records) bodies_.Add(AsNew(std::move(record)));
  snapshot->Restore(*world_);
  world_->SetDestructionListener(this);
  former.world_->SetDestructionListener(&former);
  snapshot_ = snapshot;
  return true;
}

std::vector<BodyRecord> World::RemoveAll() {
  std::vector<BodyRecord> records;
  bodies_.ForEach([&](Body body, BodyRecord& record) {
    mechanisms_.ForEachMap([&](auto& map) { map.RemoveFrom(body); });
    lidars_.RemoveFrom(body);
    records.push_back(std::move(record));
    bodies_.Remove(body);
  });
  joints_.ForEach([&](Joint joint, b2Joint*) { joints_.Remove(joint); });
  crowds_.ForEach([&](CrowdHandle crowd, const Crowd&) { crowds_.Remove(crowd); });
  bodies_.ChangeStructure();
  return records;
}

std::vector<World::Body> World::GetLayers() const {
  const AccessGuard guard(*this);
  std::vector<Body> layers;
  bodies_.ForEach([&](Body body, const BodyRecord& record) {
    if (record.is_layer) layers.push_back(body);
  });
  return layers;
}

}  // namespace flatland
