/// World: copies.

#include "base/box2d_internals.hpp"
#include "world/box2d_copies.hpp"
#include "world/layers.hpp"
#include "world/world.hpp"
#include "world/world_state.hpp"

namespace flatland {
namespace {

/// Makes a fixture as World::AddFixture does; the body gets its mass later.
b2Fixture* CopyFixture(b2Body& body, b2Fixture& old) {
  b2FixtureDef definition = box2d::DefinitionOf(old);
  const float density = definition.density;
  definition.density = 0.0f;
  b2Fixture* fixture = body.CreateFixture(&definition);
  fixture->SetDensity(density);
  return fixture;
}

}  // namespace

std::unique_ptr<World> World::Copy() const {
  const AccessGuard guard(*this);
  return Copy(WorldState::Of(*this));
}

std::unique_ptr<World> World::Copy(const WorldState& state) const {
  auto copy = std::make_unique<World>(velocity_iterations_, position_iterations_, layers_->room());
  copy->bodies_ = bodies_;
  copy->bodies_.ChangeStructure();  // caches were copied from this world
  copy->layers_->CopyFrom(*layers_);
  copy->lidars_.CopyFrom(lidars_);
  copy->joints_ = joints_;
  copy->crowds_ = crowds_;
  copy->mechanisms_ = mechanisms_;
  copy->mechanisms_.drifts = MountedMap<BodyDrift>("drift");  // no copy's odometry is read
  copy->bodies_.ForEach([&](Body, BodyRecord& record) {
    b2MassData mass;
    record.body->GetMassData(&mass);
    b2BodyDef definition = box2d::DefinitionOf(*record.body);
    record.body = copy->world_->CreateBody(&definition);
    record.contact_events = kNoContactEvents;
    record.is_recorded = false;
    record.nearby = {};
    for (BodyRecord::FixtureRecord& each : record.fixtures) {
      each.fixture = CopyFixture(*record.body, *each.fixture);
    }
    record.SetMass(mass);
  });
  const auto copy_of = [&](b2Body* old) {
    const auto index = static_cast<uint32_t>(old->GetUserData().pointer);
    return copy->bodies_.Get(copy->bodies_.HandleAt(index)).body;
  };
  copy->joints_.ForEach([&](Joint, b2Joint*& joint) {
    b2Joint* const old = joint;
    joint =
        box2d::CopyJoint(*copy->world_, *old, copy_of(old->GetBodyA()), copy_of(old->GetBodyB()));
    copy->mechanisms_.ReplaceJoint(old, joint);
  });
  state.Restore(*copy);
  return copy;
}

}  // namespace flatland
