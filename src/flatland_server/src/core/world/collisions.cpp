#include "world/collisions.hpp"

#include <algorithm>
#include <utility>

namespace flatland {

void Collisions::Restore(Collision collision) {
  const auto known = Find(collision.a, collision.b);
  if (known != present_.end()) present_.erase(known);
  count_ = std::max(count_, collision.number);
  const auto is_before = [](const Collision& one, const Collision& other) {
    return one.number < other.number;
  };
  present_.insert(std::upper_bound(present_.begin(), present_.end(), collision, is_before),
                  std::move(collision));
}

void Collisions::Begin(const Contact& contact, bool has_sensor) {
  // The solver skips contacts of sensors, so they are recorded here. Solid ones are recorded in
  // Solve.
  if (has_sensor) present_.push_back({++count_, contact.a, contact.b, true, {}, {}, {}});
}

void Collisions::Solve(const Contact& contact, const b2ContactImpulse& impulse) {
  auto found = Find(contact.a, contact.b);
  if (found == present_.end()) {
    found = present_.insert(found, {++count_, contact.a, contact.b, false, {}, {}, {}});
  }
  found->points = contact.Points();
  found->normal = contact.Normal();
  found->impulses.resize(std::max<std::size_t>(found->impulses.size(), impulse.count));
  for (int i = 0; i < impulse.count; ++i) {
    found->impulses[i] += static_cast<double>(impulse.normalImpulses[i]);
  }
  found->impulses.resize(std::min(found->impulses.size(), found->points.size()));
}

void Collisions::End(Fixture a, Fixture b) {
  const auto found = Find(a, b);
  if (found == present_.end()) return;
  if (!found->impulses.empty()) ended_.push_back(std::move(*found));
  present_.erase(found);
}

void Collisions::EndStep(double dt) {
  last_step_ = dt;
  if (present_.empty() && ended_.empty() && last_.empty()) return;
  present_.erase(std::remove_if(present_.begin(), present_.end(),
                                [this](const Collision& each) { return !Lasts(each); }),
                 present_.end());
  last_ = present_;
  last_.insert(last_.end(), ended_.begin(), ended_.end());
  ended_.clear();
  for (Collision& each : present_) each.impulses.clear();
}

std::vector<Collision>::iterator Collisions::Find(Fixture a, Fixture b) {
  return std::find_if(present_.begin(), present_.end(),
                      [&](const Collision& each) { return each.a == a && each.b == b; });
}

bool Collisions::Lasts(const Collision& collision) const {
  if (collision.has_sensor || !collision.impulses.empty()) return true;
  const auto rests = [&](Fixture fixture) {
    if (!bodies_.Contains(fixture.body)) return false;  // restored without a contact
    const b2Body& body = *bodies_.Get(fixture.body).body;
    return body.GetType() != b2_dynamicBody || !body.IsAwake();
  };
  return rests(collision.a) && rests(collision.b);
}

}  // namespace flatland
