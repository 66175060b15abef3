/// How a World tells of its contacts.

#include <algorithm>

#include "flatland_server/world.hpp"

namespace flatland {
namespace {

Handle<BodyRecord> HandleOf(const SlotMap<BodyRecord>& bodies, const b2Fixture& fixture) {
  const b2Body* body = fixture.GetBody();
  return bodies.HandleAt(static_cast<uint32_t>(const_cast<b2Body*>(body)->GetUserData().pointer));
}

uint32_t IndexOf(const b2Fixture& fixture) {
  return static_cast<uint32_t>(const_cast<b2Fixture&>(fixture).GetUserData().pointer);
}

}  // namespace

void World::SetContactListener(ContactListener* listener) {
  const Turn turn(*this);
  listener_ = listener;
}

void World::ListenTo(Body body, uint8_t hooks) {
  RequireAccess();
  bodies_.Get(body).hooks = hooks;
  bool is_anyone_heard = false;
  bodies_.ForEach([&](Body, const BodyRecord& record) { is_anyone_heard |= record.hooks != 0; });
  world_.SetContactListener(is_anyone_heard ? this : nullptr);
}

bool World::IsHeard(b2Contact& contact, ContactHooks moment) const {
  if (listener_ == nullptr) return false;
  const auto hooks = [&](const b2Fixture* fixture) {
    return bodies_.Get(HandleOf(bodies_, *fixture)).hooks;
  };
  return ((hooks(contact.GetFixtureA()) | hooks(contact.GetFixtureB())) & moment) != 0;
}

Contact World::MakeContact(b2Contact& contact, ContactHooks moment) const {
  const auto fixture = [&](const b2Fixture* f) {
    return Fixture{HandleOf(bodies_, *f), IndexOf(*f)};
  };
  return Contact(contact, moment, fixture(contact.GetFixtureA()), fixture(contact.GetFixtureB()));
}

void World::Tell(Contact& contact) {
  listening_thread_ = std::this_thread::get_id();
  listener_->OnContact(contact);
  listening_thread_ = std::thread::id();
}

void World::BeginContact(b2Contact* contact) {
  if (!IsHeard(*contact, kBeginContact)) return;
  Contact told = MakeContact(*contact, kBeginContact);
  Tell(told);
}

void World::EndContact(b2Contact* contact) {
  if (!IsHeard(*contact, kEndContact)) return;
  Contact told = MakeContact(*contact, kEndContact);
  Tell(told);
}

void World::PreSolve(b2Contact* contact, const b2Manifold* old_manifold) {
  if (!IsHeard(*contact, kPreSolve)) return;
  Contact told = MakeContact(*contact, kPreSolve);
  for (int i = 0; i < old_manifold->pointCount; ++i) {
    const b2ManifoldPoint& point = old_manifold->points[i];
    told.old_manifold.local_points.push_back({point.localPoint.x, point.localPoint.y});
    told.old_manifold.normal_impulses.push_back(point.normalImpulse);
    told.old_manifold.tangent_impulses.push_back(point.tangentImpulse);
  }
  Tell(told);
}

void World::PostSolve(b2Contact* contact, const b2ContactImpulse* impulse) {
  if (!IsHeard(*contact, kPostSolve)) return;
  Contact told = MakeContact(*contact, kPostSolve);
  const float* normal = impulse->normalImpulses;
  const float* tangent = impulse->tangentImpulses;
  told.impulse.normal_impulses.assign(normal, normal + impulse->count);
  told.impulse.tangent_impulses.assign(tangent, tangent + impulse->count);
  Tell(told);
}

}  // namespace flatland
