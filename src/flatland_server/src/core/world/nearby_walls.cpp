#include "world/nearby_walls.hpp"

#include <algorithm>

#include "base/to_box2d.hpp"

namespace flatland {
namespace {

/// True if all are equal: then one material is kept in place of one for each wall.
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

size_t NearbyWalls::CountWalls(uint32_t block) const {
  size_t count = 0;
  walls().ForEachWall(block, [&](uint32_t) { ++count; });
  return count;
}

NearbyWalls::Held::iterator NearbyWalls::Place(uint32_t number) {
  return std::lower_bound(held_.begin(), held_.end(), number,
                          [](const Block& block, uint32_t other) { return block.number < other; });
}

void NearbyWalls::Hold(b2World& world, uint32_t number) {
  const auto place = Place(number);
  if (place != held_.end() && place->number == number) {
    ++place->holders;
    return;
  }
  b2BodyDef definition;
  definition.userData.pointer = owner_;
  b2Body& body = *world.CreateBody(&definition);
  held_.insert(place, {number, 1, &body});
  walls().ForEachWall(number, [&](uint32_t index) {
    const b2EdgeShape edge = EdgeOf(walls().segments()[index]);
    const Material& material = GetMaterial(index);
    b2FixtureDef fixture;
    fixture.shape = &edge;
    fixture.userData.pointer = index;
    fixture.friction = material.friction;
    fixture.restitution = material.restitution;
    fixture.filter.categoryBits = layers_;
    fixture.filter.maskBits = layers_;
    body.CreateFixture(&fixture);
  });
}

void NearbyWalls::Release(b2World& world, uint32_t number) {
  const auto place = Place(number);
  if (--place->holders > 0) return;
  world.DestroyBody(place->body);
  held_.erase(place);
}

void NearbyWalls::AppendFixtures(std::vector<b2Fixture*>& fixtures) const {
  for (const Block& block : held_) {
    b2Fixture* fixture = block.body->GetFixtureList();
    for (; fixture != nullptr; fixture = fixture->GetNext()) fixtures.push_back(fixture);
  }
}

b2Fixture* NearbyWalls::Find(uint32_t wall) {
  Box box;
  box.Add(walls().segments()[wall]);
  b2Fixture* its = nullptr;
  ForEachBlockAt(box, [&](uint32_t number) {
    const auto place = Place(number);
    if (its != nullptr || place == held_.end() || place->number != number) return;
    b2Fixture* fixture = place->body->GetFixtureList();
    while (fixture != nullptr && fixture->GetUserData().pointer != wall) {
      fixture = fixture->GetNext();
    }
    its = fixture;
  });
  return its;
}

const Material& NearbyWalls::GetMaterial(uint32_t wall) const {
  if (changed_.empty()) return material_;
  const auto found = changed_.find(wall);
  return found == changed_.end() ? material_ : found->second;
}

void NearbyWalls::SetMaterial(uint32_t wall, const Material& material) {
  changed_[wall] = material;
  if (b2Fixture* const fixture = Find(wall)) Apply(*fixture);
}

std::vector<Material> NearbyWalls::GetMaterials() const {
  if (changed_.empty()) return {material_};
  std::vector<Material> materials(size(), material_);
  for (const auto& [wall, material] : changed_) materials[wall] = material;
  if (AreEqual(materials)) materials.resize(1);
  return materials;
}

void NearbyWalls::SetMaterials(const std::vector<Material>& materials) {
  if (materials == GetMaterials()) return;
  changed_.clear();
  if (!materials.empty()) material_ = materials.front();
  for (uint32_t wall = 1; wall < materials.size(); ++wall) {
    if (!(materials[wall] == material_)) changed_[wall] = materials[wall];
  }
  std::vector<b2Fixture*> fixtures;
  AppendFixtures(fixtures);
  for (b2Fixture* const each : fixtures) Apply(*each);
}

void NearbyWalls::Apply(b2Fixture& wall) const {
  const Material& material = GetMaterial(static_cast<uint32_t>(wall.GetUserData().pointer));
  wall.SetFriction(material.friction);
  wall.SetRestitution(material.restitution);
}

}  // namespace flatland
