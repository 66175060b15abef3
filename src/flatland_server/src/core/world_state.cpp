/// World: saving and restoring its state.
///
/// Box2D has no functions for this. Its tree of bounding boxes depends on the whole past, and
/// decides in which order contacts are found, hence solved. So a restored world is a new b2World:
/// bodies, fixtures and joints are made again in the order of the old ones, their state is copied,
/// and contacts are made in their old order. Saving rebuilds the saved world as well, so that it
/// goes on like one that is restored from it.

#include "world_state.hpp"

#include <cstring>

#include "archive.hpp"
#include "box2d_copies.hpp"
#include "box2d_internals.hpp"
#include "box2d_limits.hpp"
#include "flatland_server/world.hpp"
#include "layers.hpp"
#include "to_box2d.hpp"

namespace flatland {
namespace {

constexpr uint32_t kFormat = 2;

// ---- Reading the state of Box2D's objects ----

Material MaterialOf(const b2Fixture& fixture) {
  return {fixture.GetFriction(), fixture.GetRestitution()};
}

BodyState StateOf(b2Body& body, const std::vector<BodyRecord::FixtureRecord>& fixtures) {
  BodyState state;
  state.position = body.GetPosition();
  state.sweep = box2d::Sweep(body);
  state.velocity = body.GetLinearVelocity();
  state.omega = body.GetAngularVelocity();
  state.force = box2d::Force(body);
  state.torque = box2d::Torque(body);
  state.sleep_time = box2d::SleepTime(body);
  state.is_awake = body.IsAwake();
  bool all_equal = true;
  for (const BodyRecord::FixtureRecord& each : fixtures) {
    state.materials.push_back(MaterialOf(*each.fixture));
    all_equal = all_equal && state.materials.back() == state.materials.front();
  }
  if (all_equal && !fixtures.empty()) state.materials.resize(1);
  return state;
}

std::array<float, 5> ImpulsesOf(b2Joint& joint) {
  if (joint.GetType() == e_weldJoint) {
    const b2Vec3 impulse = box2d::WeldInternals::Impulse(static_cast<b2WeldJoint&>(joint));
    return {impulse.x, impulse.y, impulse.z, 0.0f, 0.0f};
  }
  using Internals = box2d::RevoluteInternals;
  auto& hinge = static_cast<b2RevoluteJoint&>(joint);
  const b2Vec2 impulse = Internals::Impulse(hinge);
  return {impulse.x, impulse.y, Internals::MotorImpulse(hinge), Internals::LowerImpulse(hinge),
          Internals::UpperImpulse(hinge)};
}

void SetImpulses(b2Joint& joint, const std::array<float, 5>& impulses) {
  if (joint.GetType() == e_weldJoint) {
    box2d::WeldInternals::Impulse(static_cast<b2WeldJoint&>(joint)) = {impulses[0], impulses[1],
                                                                       impulses[2]};
    return;
  }
  using Internals = box2d::RevoluteInternals;
  auto& hinge = static_cast<b2RevoluteJoint&>(joint);
  Internals::Impulse(hinge) = {impulses[0], impulses[1]};
  Internals::MotorImpulse(hinge) = impulses[2];
  Internals::LowerImpulse(hinge) = impulses[3];
  Internals::UpperImpulse(hinge) = impulses[4];
}

// ---- Making Box2D's objects again ----

b2Body* CopyBody(b2World& world, b2Body& old, const BodyState& state) {
  b2BodyDef definition = box2d::DefinitionOf(old);
  definition.position = state.position;
  definition.angle = state.sweep.a;
  return world.CreateBody(&definition);
}

b2Fixture* CopyFixture(b2Body& body, b2Fixture& old, const Material& material) {
  b2FixtureDef definition = box2d::DefinitionOf(old);
  definition.friction = material.friction;
  definition.restitution = material.restitution;
  return body.CreateFixture(&definition);
}

/// Makes a contact that is in a state, unless the two cannot collide. It becomes Box2D's newest.
void CopyContact(b2World& world, b2Fixture& a, b2Fixture& b, const ContactState& state) {
  auto& manager = const_cast<b2ContactManager&>(world.GetContactManager());
  const int32 before = manager.m_contactCount;
  manager.AddPair(box2d::FixtureInternals::Proxies(a), box2d::FixtureInternals::Proxies(b));
  if (manager.m_contactCount == before) return;
  b2Contact& contact = *manager.m_contactList;
  using Internals = box2d::ContactInternals;
  Internals::Flags(contact) =
      (state.is_touching ? Internals::kTouching : 0) | (state.is_enabled ? Internals::kEnabled : 0);
  *contact.GetManifold() = state.manifold;
  contact.SetFriction(state.friction);
  contact.SetRestitution(state.restitution);
  contact.SetTangentSpeed(state.tangent_speed);
}

/// Sets what making the fixtures, joints and contacts of a body has changed.
void SetState(b2Body& body, const BodyState& state) {
  body.SetLinearVelocity(state.velocity);
  body.SetAngularVelocity(state.omega);
  body.SetAwake(state.is_awake);
  box2d::Sweep(body).c0 = state.sweep.c0;
  box2d::Sweep(body).c = state.sweep.c;
  box2d::Sweep(body).a0 = state.sweep.a0;
  box2d::Force(body) = state.force;
  box2d::Torque(body) = state.torque;
  box2d::SleepTime(body) = state.sleep_time;
}

/// Writes or reads the mechanisms of a map, which must be on the same bodies.
template <class Archive, class Map>
void SerializeMounted(Archive& archive, Map& map, const std::vector<uint32_t>& order,
                      const char* what) {
  archive.Same(static_cast<uint32_t>(map.size()), what);
  map.ForEach([&](auto, auto& mounted) {
    archive.Same(order[mounted.body.index], "the body of a drive, tween or drift");
    archive(mounted.mechanism);
  });
}

}  // namespace

WorldState WorldState::Of(const World& world) {
  WorldState state;
  state.inverse_step = box2d::InverseStep(*world.world_);
  std::vector<uint32_t> order(world.bodies_.slot_count());  // by the index of a handle
  world.bodies_.ForEach([&](World::Body handle, const BodyRecord& record) {
    order[handle.index] = static_cast<uint32_t>(state.bodies.size());
    state.bodies.push_back(StateOf(*record.body, record.fixtures));
    if (const NearbyWalls* large = world.layers_->LargeLayerOf(record)) {
      state.bodies.back().materials = large->GetMaterials();
    }
  });
  world.joints_.ForEach(
      [&](World::Joint, b2Joint* joint) { state.joints.push_back(ImpulsesOf(*joint)); });
  for (b2Contact* c = world.world_->GetContactList(); c != nullptr; c = c->GetNext()) {
    const auto end_of = [&](b2Fixture& fixture) {
      return ContactState::End{order[fixture.GetBody()->GetUserData().pointer],
                               static_cast<uint32_t>(fixture.GetUserData().pointer)};
    };
    // Without points, the rest of a manifold is not initialised.
    const bool has_points = c->GetManifold()->pointCount > 0;
    state.contacts.push_back({end_of(*c->GetFixtureA()), end_of(*c->GetFixtureB()), c->IsTouching(),
                              c->IsEnabled(), c->GetFriction(), c->GetRestitution(),
                              c->GetTangentSpeed(), has_points ? *c->GetManifold() : b2Manifold{}});
  }
  state.mechanisms = world.mechanisms_;
  state.crowds = world.crowds_;
  return state;
}

template <class Archive>
void WorldState::Serialize(Archive& archive, const World& world) {
  archive.Same(kFormat, "its format");
  archive(inverse_step);
  if constexpr (Archive::kIsReader) {
    if (inverse_step < 0.0f) Archive::Fail();
  }
  std::vector<const BodyRecord*> records;
  std::vector<uint32_t> order(world.bodies_.slot_count());  // by the index of a handle
  world.bodies_.ForEach([&](World::Body handle, const BodyRecord& record) {
    order[handle.index] = static_cast<uint32_t>(records.size());
    records.push_back(&record);
  });
  archive.Same(static_cast<uint32_t>(records.size()), "the number of bodies");
  for (size_t i = 0; i < records.size(); ++i) {
    BodyState& body = bodies[i];
    const size_t fixtures = world.layers_->FixtureCountOf(*records[i]);
    archive.Same(records[i]->body->GetType(), "the type of a body");
    archive.Same(static_cast<uint32_t>(fixtures), "the number of footprints or walls of a body");
    archive(body);
    bool all_equal = body.materials.size() <= 1;
    archive(all_equal);
    body.materials.resize(all_equal ? std::min<size_t>(fixtures, 1) : fixtures);
    for (Material& material : body.materials) archive(material);
  }
  archive.Same(static_cast<uint32_t>(joints.size()), "the number of joints");
  size_t joint_index = 0;
  world.joints_.ForEach([&](World::Joint, const b2Joint* joint) {
    archive.Same(joint->GetType(), "the type of a joint");
    for (float& impulse : joints[joint_index]) archive(impulse);
    ++joint_index;
  });
  auto count = static_cast<uint32_t>(contacts.size());
  archive(count);
  if constexpr (Archive::kIsReader) {
    if (count > archive.remaining() / sizeof(ContactState::End)) Archive::Fail();
    contacts.assign(count, {});
  }
  for (ContactState& contact : contacts) {
    archive(contact);
    if constexpr (Archive::kIsReader) {
      bool with_sensor = false;
      for (const ContactState::End& end : {contact.a, contact.b}) {
        if (end.body >= records.size()) Archive::Fail();
        const BodyRecord& record = *records[end.body];
        if (end.fixture >= world.layers_->FixtureCountOf(record)) Archive::Fail();
        const bool is_sensor = !record.is_layer && record.fixtures[end.fixture].fixture->IsSensor();
        with_sensor = with_sensor || is_sensor;
      }
      // The solver asserts that solid fixtures that touch have points.
      const bool has_points = contact.manifold.pointCount > 0;
      if (!with_sensor && contact.is_touching != has_points) Archive::Fail();
    }
  }
  SerializeMounted(archive, mechanisms.drives, order, "the number of drives");
  SerializeMounted(archive, mechanisms.tricycles, order, "the number of tricycle drives");
  SerializeMounted(archive, mechanisms.tweens, order, "the number of tweens");
  SerializeMounted(archive, mechanisms.drifts, order, "the number of drifts");
  archive.Same(static_cast<uint32_t>(crowds.size()), "the number of crowds");
  crowds.ForEach([&](auto, Crowd& crowd) {
    archive.Same(static_cast<uint32_t>(crowd.size()), "the number of people of a crowd");
    crowd.ForEachPart([&](auto& part) { archive(part); });
    if constexpr (Archive::kIsReader) {
      if (!crowd.IsValid()) Archive::Fail();
    }
  });
}

std::string World::SaveState() {
  const AccessGuard guard(*this);
  WorldState state = WorldState::Of(*this);
  Writer writer;
  state.Serialize(writer, *this);
  state.Restore(*this);
  std::string bytes = std::move(writer).bytes();
  const uint64_t sum = Checksum(bytes);
  return bytes.append(reinterpret_cast<const char*>(&sum), sizeof sum);
}

void World::RestoreState(std::string_view bytes) {
  const AccessGuard guard(*this);
  // Numbers at random may be such that Box2D's assertions fail some steps later.
  uint64_t sum = 0;
  if (bytes.size() < sizeof sum) Reader::Fail();
  const std::string_view content = bytes.substr(0, bytes.size() - sizeof sum);
  std::memcpy(&sum, bytes.data() + content.size(), sizeof sum);
  if (sum != Checksum(content)) Reader::Fail();
  WorldState state = WorldState::Of(*this);
  Reader reader(content);
  state.Serialize(reader, *this);
  if (reader.remaining() > 0) Reader::Fail();
  state.Restore(*this);
}

void WorldState::Restore(World& world) const {
  auto rebuilt = std::make_unique<b2World>(b2Vec2_zero);
  rebuilt->SetDestructionListener(&world);
  box2d::InverseStep(*rebuilt) = inverse_step;
  std::vector<BodyRecord*> records;
  bool has_layers_alone = true;
  world.bodies_.ForEach([&](auto, BodyRecord& record) {
    const BodyState& of_body = bodies[records.size()];
    b2Body* body = CopyBody(*rebuilt, *record.body, of_body);
    for (size_t i = 0; i < record.fixtures.size(); ++i) {
      const Material& material = of_body.materials[of_body.materials.size() == 1 ? 0 : i];
      record.fixtures[i].fixture = CopyFixture(*body, *record.fixtures[i].fixture, material);
    }
    if (NearbyWalls* large = world.layers_->LargeLayerOf(record))
      large->SetMaterials(of_body.materials);
    record.body = body;
    record.has_changed_material = true;
    records.push_back(&record);
    has_layers_alone = has_layers_alone && record.is_layer;
    if (has_layers_alone) box2d::SkipPairsOfNewFixtures(*rebuilt);
  });
  const auto copy_of = [&](b2Body* old) { return world.bodies_.RecordOf(*old).body; };
  world.mechanisms_ = mechanisms;
  size_t joint_index = 0;
  world.joints_.ForEach([&](World::Joint, b2Joint*& joint) {
    b2Joint* old = joint;
    joint = box2d::CopyJoint(*rebuilt, *old, copy_of(old->GetBodyA()), copy_of(old->GetBodyB()));
    SetImpulses(*joint, joints[joint_index++]);
    world.mechanisms_.ReplaceJoint(old, joint);
  });
  world.layers_->ForgetHeldWalls();
  world.world_ = std::move(rebuilt);
  world.layers_->HoldWallsNearBodies(*world.world_);
  for (auto contact = contacts.rbegin(); contact != contacts.rend(); ++contact) {
    b2Fixture* const a =
        world.layers_->FixtureOrNull(*records[contact->a.body], contact->a.fixture);
    b2Fixture* const b =
        world.layers_->FixtureOrNull(*records[contact->b.body], contact->b.fixture);
    // A wall that Box2D does not have is too far away to be touched.
    if (a != nullptr && b != nullptr) CopyContact(*world.world_, *a, *b, *contact);
  }
  for (size_t i = 0; i < records.size(); ++i) SetState(*records[i]->body, bodies[i]);
  world.contacts_.ChooseReports();
  world.bodies_.ForEach(
      [](auto, BodyRecord& record) { record.may_move = record.may_move || IsWound(*record.body); });
  world.crowds_ = crowds;
  world.crowds_.ForEach([&](auto, Crowd& crowd) { crowd.Restore(world.bodies_); });
  world.bodies_.ChangeStructure();
}

}  // namespace flatland
