#include "layers.hpp"

#include <algorithm>
#include <optional>
#include <utility>

#include "box2d_internals.hpp"
#include "flatland_server/segment_tree.hpp"
#include "flatland_server/visible_fixture.hpp"
#include "saved_tree.hpp"
#include "tree_order.hpp"

namespace flatland {
namespace {

/// Distance that a body moves before the walls near it are looked up again [m].
constexpr float kSlack = 0.5f;
/// Walls within this of a body's reach are near it [m]. In a step, Box2D moves no body farther than
/// b2_maxTranslation; the rest is for the skin of shapes, and for rounding.
constexpr float kNear = b2_maxTranslation + kSlack + 0.2f;

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

std::vector<b2AABB> BoxesOf(const std::vector<Segment>& walls) {
  std::vector<b2AABB> boxes(walls.size());
  b2Transform identity;
  identity.SetIdentity();
  for (size_t i = 0; i < walls.size(); ++i) EdgeOf(walls[i]).ComputeAABB(&boxes[i], identity, 0);
  return boxes;
}

std::vector<b2Fixture*> FixturesOf(const BodyRecord& record) {
  std::vector<b2Fixture*> fixtures;
  for (const BodyRecord::FixtureRecord& each : record.fixtures) fixtures.push_back(each.fixture);
  return fixtures;
}

}  // namespace

bool Layers::BeginWith(const std::vector<Layer>& layers) const {
  if (layers.size() > all_.size()) return false;
  return std::equal(layers.begin(), layers.end(), all_.begin(), [](const Layer& a, const Layer& b) {
    return a.walls == b.walls && a.bits == b.bits;
  });
}

void Layers::TakeFrom(Layers& other, std::size_t count) {
  other.all_.resize(count);
  const auto is_large = [&](const Layer& each) { return each.walls->segment_count() > large_; };
  other.large_layers_.resize(
      static_cast<std::size_t>(std::count_if(other.all_.begin(), other.all_.end(), is_large)));
  for (const auto& large : other.large_layers_) {
    large->Clear();
    large->SetMaterials({kDefaultMaterial});
  }
  all_ = std::exchange(other.all_, {});
  large_layers_ = std::exchange(other.large_layers_, {});
}

Bodies::Body Layers::Add(b2World& world, std::vector<Segment> walls, LayerBits bits,
                         const std::function<void(std::size_t added)>& progress) {
  const bool has_layers_alone = AreAlone(world);
  const b2BodyDef definition;
  BodyRecord record;
  record.body = world.CreateBody(&definition);
  record.is_layer = true;
  record.may_move = false;
  const bool is_large = walls.size() > large_;
  std::shared_ptr<const WallTree> tree;  // of these walls alone, if it is known
  if (!is_large && has_layers_alone && box2d::InsertionCount(world) == 0) {
    tree = WallTree::Latest({BoxesOf(walls)});
  }
  std::optional<box2d::OutsideTree> outside;
  if (tree != nullptr) outside.emplace(*record.body);
  if (is_large) {
    record.large_layer = static_cast<int>(large_layers_.size());
    all_.push_back({SegmentTree::Share(std::move(walls), progress), bits});
  } else {
    record.fixtures.reserve(walls.size());
    for (const Segment& wall : walls) {
      const auto index = static_cast<uint32_t>(record.fixtures.size());
      record.fixtures.push_back(
          {AddWall(*record.body, wall, index, bits, kDefaultMaterial), false, 0.0});
      const size_t added = record.fixtures.size();
      const bool is_due = added % SegmentTree::kProgressStep == 0 || added == walls.size();
      if (progress && is_due) progress(added);
    }
    all_.push_back({SegmentTree::Share(std::move(walls)), bits});
  }
  outside.reset();
  if (tree != nullptr) tree->PutInto(world, FixturesOf(record));
  if (has_layers_alone) box2d::SkipPairsOfNewFixtures(world);
  const Bodies::Body handle = bodies_.Add(std::move(record));
  // A slot of a later generation was that of a body, whose moves have changed the tree.
  if (has_layers_alone && handle.generation == 1 && tree == nullptr) box2d::OrderNodes(world);
  if (is_large) {
    large_layers_.push_back(std::make_unique<NearbyWalls>(all_.back().walls, bits, handle.index));
    bodies_.ForEach([](auto, BodyRecord& each) { each.nearby.is_current = false; });
  }
  return handle;
}

int Layers::held_body_count() const {
  int count = 0;
  for (const auto& each : large_layers_) count += each->held_count();
  return count;
}

int Layers::held_wall_count() const {
  int count = 0;
  for (const auto& each : large_layers_) count += each->held_wall_count();
  return count;
}

NearbyWalls* Layers::LargeLayerOf(const BodyRecord& record) const {
  return record.large_layer < 0 ? nullptr : large_layers_[record.large_layer].get();
}

size_t Layers::FixtureCountOf(const BodyRecord& record) const {
  const NearbyWalls* large = LargeLayerOf(record);
  return large == nullptr ? record.fixtures.size() : large->size();
}

void Layers::HoldWallsNearBodies(b2World& world) {
  if (large_layers_.empty()) return;
  bodies_.ForEach([&](auto, BodyRecord& record) {
    if (record.body->GetType() != b2_dynamicBody) return;
    const b2Vec2 way = record.body->GetWorldCenter() - record.nearby.center;
    if (record.nearby.is_current && std::max(std::abs(way.x), std::abs(way.y)) <= kSlack) return;
    HoldWallsNear(world, record);
  });
}

void Layers::HoldWallsNear(b2World& world, BodyRecord& record) {
  const Reach reach(record);
  const b2Vec2 center = record.body->GetWorldCenter();
  const double size = double{reach.radius} + kNear;
  const Box box{{center.x - size, center.y - size}, {center.x + size, center.y + size}};
  std::vector<std::vector<uint32_t>> blocks;
  const int32 moves = box2d::MoveCount(world);
  for (const auto& layer : large_layers_) {
    const bool collides = (layer->layers() & reach.layers) != 0;
    blocks.push_back(collides ? layer->BlocksAt(box) : std::vector<uint32_t>());
    layer->Hold(world, blocks.back());
  }
  // The body looks for the walls: in a large world, it would take long if each wall did.
  box2d::SkipPairsOfNewFixtures(world, moves);
  box2d::FindPairsAgain(*record.body);
  ReleaseWallsNear(world, record);
  record.nearby = {true, center, std::move(blocks)};
}

void Layers::ReleaseWallsNear(b2World& world, BodyRecord& record) {
  for (size_t i = 0; i < record.nearby.blocks.size(); ++i) {
    large_layers_[i]->Release(world, record.nearby.blocks[i]);
  }
  record.nearby = {};
}

void Layers::HoldWallsOf(b2World& world, BodyRecord& record, BodyRecord::Nearby nearby) {
  for (size_t i = 0; i < nearby.blocks.size(); ++i) {
    large_layers_[i]->Hold(world, nearby.blocks[i]);
  }
  record.nearby = std::move(nearby);
}

void Layers::AppendHeldFixtures(std::vector<b2Fixture*>& fixtures) const {
  for (const auto& layer : large_layers_) {
    for (b2Body* body : layer->HeldBodies()) {
      b2Fixture* fixture = body->GetFixtureList();
      for (; fixture != nullptr; fixture = fixture->GetNext()) fixtures.push_back(fixture);
    }
  }
}

b2Fixture* Layers::FixtureOrNull(const BodyRecord& record, uint32_t index) const {
  const NearbyWalls* large = LargeLayerOf(record);
  return large == nullptr ? record.fixtures[index].fixture : large->Find(index);
}

}  // namespace flatland
