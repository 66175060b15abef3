#include "nearby_walls.hpp"

#include <algorithm>

#include "to_box2d.hpp"

namespace flatland {
namespace {

constexpr size_t kLeavesPerBlock = 8;

/// As many materials as there are walls are as good as one, if they are equal.
bool AreEqual(const std::vector<Material>& materials) {
  return std::all_of(materials.begin(), materials.end(),
                     [&](const Material& each) { return each == materials.front(); });
}

}  // namespace

b2EdgeShape EdgeOf(const Segment& wall) {
  b2EdgeShape edge;
  edge.SetTwoSided(ToBox2D(wall.a), ToBox2D(wall.b));
  return edge;
}

b2Fixture* AddWall(b2Body& body, const Segment& wall, uint32_t index, LayerBits layers,
                   const Material& material) {
  const b2EdgeShape edge = EdgeOf(wall);
  b2FixtureDef fixture;
  fixture.shape = &edge;
  fixture.userData.pointer = index;
  fixture.friction = material.friction;
  fixture.restitution = material.restitution;
  fixture.filter.categoryBits = layers;
  fixture.filter.maskBits = layers;
  return body.CreateFixture(&fixture);
}

std::vector<uint32_t> NearbyWalls::BlocksAt(const Box& box) const {
  std::vector<uint32_t> blocks;
  walls_->ForEachLeafAt(box, [&](size_t leaf) {
    const auto block = static_cast<uint32_t>(leaf / kLeavesPerBlock);
    if (blocks.empty() || blocks.back() != block) blocks.push_back(block);
  });
  return blocks;
}

template <class Visit>
void NearbyWalls::ForEachWall(uint32_t block, Visit visit) const {
  const size_t begin = block * kLeavesPerBlock;
  const size_t end = std::min(begin + kLeavesPerBlock, walls_->leaf_count());
  for (size_t leaf = begin; leaf < end; ++leaf) {
    walls_->ForEachWall(leaf, visit);
  }
}

void NearbyWalls::Hold(b2World& world, const std::vector<uint32_t>& blocks) {
  for (const uint32_t number : blocks) {
    Block& block = held_[number];
    if (block.holders++ > 0) continue;
    b2BodyDef definition;
    definition.userData.pointer = owner_;
    block.body = world.CreateBody(&definition);
    ForEachWall(number, [&](uint32_t index) {
      AddWall(*block.body, walls_->segments()[index], index, layers_, GetMaterial(index));
    });
  }
}

void NearbyWalls::Release(b2World& world, const std::vector<uint32_t>& blocks) {
  for (const uint32_t number : blocks) {
    const auto found = held_.find(number);
    if (--found->second.holders > 0) continue;
    world.DestroyBody(found->second.body);
    held_.erase(found);
  }
}

std::vector<b2Body*> NearbyWalls::HeldBodies() const {
  std::vector<b2Body*> bodies;
  for (const uint32_t number : HeldBlocks()) bodies.push_back(held_.at(number).body);
  return bodies;
}

std::set<uint32_t> NearbyWalls::HeldBlocks() const {
  std::set<uint32_t> numbers;
  for (const auto& [number, block] : held_) numbers.insert(number);
  return numbers;
}

bool NearbyWalls::IsBlock(uint32_t number) const {
  return size_t{number} * kLeavesPerBlock < walls_->leaf_count();
}

size_t NearbyWalls::CountWalls(const std::set<uint32_t>& blocks) const {
  size_t count = 0;
  for (const uint32_t number : blocks) ForEachWall(number, [&](uint32_t) { ++count; });
  return count;
}

b2Fixture* NearbyWalls::Find(uint32_t wall) const {
  Box box;
  box.Add(walls_->segments()[wall]);
  for (const uint32_t number : BlocksAt(box)) {
    const auto found = held_.find(number);
    if (found == held_.end()) continue;
    b2Fixture* fixture = found->second.body->GetFixtureList();
    for (; fixture != nullptr; fixture = fixture->GetNext()) {
      if (fixture->GetUserData().pointer == wall) return fixture;
    }
  }
  return nullptr;
}

const Material& NearbyWalls::GetMaterial(uint32_t wall) const {
  const auto found = changed_.find(wall);
  return found == changed_.end() ? material_ : found->second;
}

void NearbyWalls::SetMaterial(uint32_t wall, const Material& material) {
  changed_[wall] = material;
  b2Fixture* const fixture = Find(wall);
  if (fixture == nullptr) return;
  fixture->SetFriction(material.friction);
  fixture->SetRestitution(material.restitution);
}

std::vector<Material> NearbyWalls::GetMaterials() const {
  if (changed_.empty()) return {material_};
  std::vector<Material> materials(size(), material_);
  for (const auto& [wall, material] : changed_) materials[wall] = material;
  if (AreEqual(materials)) materials.resize(1);
  return materials;
}

void NearbyWalls::SetMaterials(const std::vector<Material>& materials) {
  changed_.clear();
  material_ = materials.front();
  if (materials.size() == 1) return;
  for (uint32_t wall = 0; wall < materials.size(); ++wall) {
    if (!(materials[wall] == material_)) changed_[wall] = materials[wall];
  }
}

}  // namespace flatland
