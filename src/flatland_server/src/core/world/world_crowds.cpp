/// World: crowds.

#include "base/box2d_limits.hpp"
#include "world/layers.hpp"
#include "world/world.hpp"

namespace flatland {

World::CrowdHandle World::AddCrowd(const CrowdSettings& settings, uint64_t key) {
  const AccessGuard guard(*this);
  return crowds_.Add(Crowd(settings, key));
}

void World::AddPerson(CrowdHandle crowd, const PersonSettings& person) {
  std::vector<Body> bodies = person.legs;
  bodies.push_back(person.body);
  if (person.circle) bodies.push_back(*person.circle);
  for (const Body& body : bodies) {
    Require(Find(body).GetType() != b2_staticBody, "a person's bodies must not be static");
  }
  const AccessGuard guard(*this);
  crowds_.Get(crowd).Add(person);
  for (const Body& body : bodies) bodies_.Get(body).is_person = true;
  bodies_.ChangeStructure();
}

bool World::ScatterCrowd(CrowdHandle crowd) {
  const AccessGuard guard(*this);
  return crowds_.Get(crowd).Scatter(bodies_, *layers_);
}

void World::RemoveCrowd(CrowdHandle crowd) {
  const AccessGuard guard(*this);
  crowds_.Remove(crowd);
}

std::vector<Crowd::Clearances> World::GetClearances(CrowdHandle crowd) {
  const AccessGuard guard(*this);
  return crowds_.Get(crowd).GetClearances(bodies_, *layers_);
}

}  // namespace flatland
