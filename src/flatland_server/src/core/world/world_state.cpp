/// World: saving and restoring its state.
///
/// Box2D has no functions for this. What a step depends on is copied: bodies, joints with their
/// impulses, contacts in their order, and the tree of bounding boxes (saved_tree.hpp), which
/// depends on the whole past and decides in which order contacts are found, hence solved.

#include "world/world_state.hpp"

#include <algorithm>
#include <cstring>
#include <set>
#include <utility>

#include "base/archive.hpp"
#include "base/box2d_internals.hpp"
#include "base/box2d_limits.hpp"
#include "world/box2d_copies.hpp"
#include "world/layers.hpp"
#include "world/world.hpp"

namespace flatland {
namespace {

constexpr uint32_t kFormat = 4;

// ---- Reading the state of Box2D's objects ----

Material MaterialOf(const b2Fixture& fixture) {
  return {fixture.GetFriction(), fixture.GetRestitution()};
}

BodyState StateOf(const BodyRecord& record, const Layers& layers) {
  BodyState state;
  if (record.is_layer) {
    state.materials = layers.NearbyOf(record)->GetMaterials();
    return state;
  }
  b2Body& body = *record.body;
  const std::vector<BodyRecord::FixtureRecord>& fixtures = record.fixtures;
  state.position = body.GetPosition();
  state.sweep = box2d::Sweep(body);
  state.velocity = body.GetLinearVelocity();
  state.omega = body.GetAngularVelocity();
  state.force = box2d::Force(body);
  state.torque = box2d::Torque(body);
  state.sleep_time = box2d::SleepTime(body);
  state.is_awake = body.IsAwake();
  body.GetMassData(&state.mass);
  bool all_equal = true;
  for (const BodyRecord::FixtureRecord& each : fixtures) {
    state.materials.push_back(MaterialOf(*each.fixture));
    all_equal = all_equal && state.materials.back() == state.materials.front();
  }
  if (all_equal && !fixtures.empty()) state.materials.resize(1);
  for (b2Fixture* each = body.GetFixtureList(); each != nullptr; each = each->GetNext()) {
    state.order.push_back(static_cast<uint32_t>(each->GetUserData().pointer));
    state.boxes.push_back(each->GetAABB(0));
  }
  state.nearby = record.nearby;
  return state;
}

JointState StateOf(b2Joint& joint) {
  if (joint.GetType() == e_weldJoint) {
    const b2Vec3 impulse = box2d::WeldInternals::Impulse(static_cast<b2WeldJoint&>(joint));
    return {{impulse.x, impulse.y, impulse.z, 0.0f, 0.0f}};
  }
  if (joint.GetType() == e_frictionJoint) {
    auto& friction = static_cast<b2FrictionJoint&>(joint);
    const b2Vec2 impulse = box2d::FrictionInternals::Impulse(friction);
    const float angular = box2d::FrictionInternals::AngularImpulse(friction);
    JointState state{{impulse.x, impulse.y, angular, friction.GetMaxForce(), 0.0f}};
    state.max_torque = friction.GetMaxTorque();
    return state;
  }
  using Internals = box2d::RevoluteInternals;
  auto& hinge = static_cast<b2RevoluteJoint&>(joint);
  const b2Vec2 impulse = Internals::Impulse(hinge);
  return {{impulse.x, impulse.y, Internals::MotorImpulse(hinge), Internals::LowerImpulse(hinge),
           Internals::UpperImpulse(hinge)},
          hinge.IsLimitEnabled(),
          hinge.GetLowerLimit(),
          hinge.GetUpperLimit(),
          hinge.IsMotorEnabled(),
          hinge.GetMotorSpeed(),
          hinge.GetMaxMotorTorque()};
}

void RestoreJoint(b2Joint& joint, const JointState& state) {
  const std::array<float, 5>& impulses = state.impulses;
  if (joint.GetType() == e_weldJoint) {
    box2d::WeldInternals::Impulse(static_cast<b2WeldJoint&>(joint)) = {impulses[0], impulses[1],
                                                                       impulses[2]};
    return;
  }
  if (joint.GetType() == e_frictionJoint) {
    auto& friction = static_cast<b2FrictionJoint&>(joint);
    box2d::FrictionInternals::Impulse(friction) = {impulses[0], impulses[1]};
    box2d::FrictionInternals::AngularImpulse(friction) = impulses[2];
    friction.SetMaxForce(std::max(impulses[3], 0.0f));
    friction.SetMaxTorque(state.max_torque);
    return;
  }
  using Internals = box2d::RevoluteInternals;
  auto& hinge = static_cast<b2RevoluteJoint&>(joint);
  hinge.EnableLimit(state.has_limits);
  hinge.SetLimits(state.lower, state.upper);
  hinge.EnableMotor(state.has_motor);
  hinge.SetMotorSpeed(state.speed);
  hinge.SetMaxMotorTorque(state.max_torque);
  Internals::Impulse(hinge) = {impulses[0], impulses[1]};
  Internals::MotorImpulse(hinge) = impulses[2];
  Internals::LowerImpulse(hinge) = impulses[3];
  Internals::UpperImpulse(hinge) = impulses[4];
}

/// All fixtures, in an order that is the same in a world that is equal.
std::vector<b2Fixture*> FixturesOf(const Bodies& bodies, const Layers& layers) {
  std::vector<b2Fixture*> fixtures;
  fixtures.reserve(bodies.size());
  bodies.ForEach([&](auto, const BodyRecord& record) {
    for (const BodyRecord::FixtureRecord& each : record.fixtures) fixtures.push_back(each.fixture);
  });
  layers.AppendHeldFixtures(fixtures);
  return fixtures;
}

// ---- Putting Box2D's objects into a state ----

void SetOrder(b2Body& body, const BodyRecord& record, const std::vector<uint32_t>& order) {
  b2Fixture* next = nullptr;
  for (auto index = order.rbegin(); index != order.rend(); ++index) {
    b2Fixture& fixture = *record.fixtures[*index].fixture;
    box2d::FixtureInternals::Next(fixture) = next;
    next = &fixture;
  }
  box2d::Fixtures(body) = next;
}

void RestoreFixtures(BodyRecord& record, const BodyState& state) {
  const std::vector<Material>& materials = state.materials;
  for (size_t i = 0; i < record.fixtures.size(); ++i) {
    const Material& material = materials[materials.size() == 1 ? 0 : i];
    record.fixtures[i].fixture->SetFriction(material.friction);
    record.fixtures[i].fixture->SetRestitution(material.restitution);
  }
  SetOrder(*record.body, record, state.order);
  for (size_t i = 0; i < state.order.size(); ++i) {
    b2Fixture& fixture = *record.fixtures[state.order[i]].fixture;
    box2d::FixtureInternals::Proxies(fixture)->aabb = state.boxes[i];
  }
}

/// Ends all contacts without calling the contact listener.
void EndContacts(b2World& world) {
  world.SetContactListener(nullptr);
  b2ContactManager& manager = box2d::Contacts(world);
  while (manager.m_contactList != nullptr) manager.Destroy(manager.m_contactList);
}

/// Makes a contact as saved in a state, unless the two cannot collide. It becomes Box2D's newest.
void MakeContact(b2World& world, b2Fixture& a, b2Fixture& b, const ContactState& state) {
  b2Contact* const contact = box2d::MakeContact(world, a, b);
  if (contact == nullptr) return;
  using Internals = box2d::ContactInternals;
  Internals::Flags(*contact) = (state.is_touching ? Internals::kTouching : 0) |
                               (state.is_enabled ? Internals::kEnabled : 0) |
                               (state.needs_filtering ? Internals::kToFilter : 0);
  *contact->GetManifold() = state.manifold;
  contact->SetFriction(state.friction);
  contact->SetRestitution(state.restitution);
  contact->SetTangentSpeed(state.tangent_speed);
}

/// Restores a body without its contacts. Making contacts wakes it.
void RestoreMotion(b2Body& body, const BodyState& state) {
  body.SetMassData(&state.mass);
  box2d::Transform(body) = b2Transform(state.position, b2Rot(state.sweep.a));
  b2Sweep& sweep = box2d::Sweep(body);
  const b2Vec2 center = sweep.localCenter;
  sweep = state.sweep;
  sweep.localCenter = center;
  sweep.alpha0 = 0.0f;
  body.SetAwake(state.is_awake);
  body.SetLinearVelocity(state.velocity);
  body.SetAngularVelocity(state.omega);
  box2d::Force(body) = state.force;
  box2d::Torque(body) = state.torque;
  box2d::SleepTime(body) = state.sleep_time;
}

template <class Map>
void Take(Map& map, const Map& values) {
  map.ForEach([&](auto handle, auto& each) { each.mechanism = values.Get(handle).mechanism; });
}

/// Restores the mechanisms, but keeps the joints that they use.
void RestoreMechanisms(Mechanisms& mechanisms, const Mechanisms& state) {
  Take(mechanisms.drives, state.drives);
  Take(mechanisms.tweens, state.tweens);
  Take(mechanisms.drifts, state.drifts);
  mechanisms.tricycles.ForEach([&](auto handle, auto& each) {
    each.mechanism.TakeMotion(state.tricycles.Get(handle).mechanism);
  });
  mechanisms.cars.ForEach([&](auto handle, auto& each) {
    each.mechanism.TakeMotion(state.cars.Get(handle).mechanism);
  });
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

/// Writes or reads drifts. Copies of worlds have none. So a world without drifts can read a state
/// with some; and if a state has none, the drifts of a world stay as they are.
template <class Archive>
void SerializeDrifts(Archive& archive, MountedMap<BodyDrift>& drifts,
                     const std::vector<uint32_t>& order) {
  auto count = static_cast<uint32_t>(drifts.size());
  archive(count);
  if (count == drifts.size()) {
    drifts.ForEach([&](auto, auto& mounted) {
      archive.Same(order[mounted.body.index], "the body of a drift");
      archive(mounted.mechanism);
    });
    return;
  }
  if constexpr (Archive::kIsReader) {
    if (drifts.size() > 0 && count > 0) Archive::Fail();
    BodyDrift unused;
    for (uint32_t body = 0; count > 0; --count) archive(body, unused);
  }
}

/// Writes or reads the order of a body's fixtures; in most cases, it is from the last to the first.
template <class Archive>
void SerializeOrder(Archive& archive, std::vector<uint32_t>& order, size_t count) {
  bool is_reverse = std::is_sorted(order.rbegin(), order.rend());
  archive(is_reverse);
  if constexpr (Archive::kIsReader) {
    order.resize(count);
    for (size_t i = 0; i < count; ++i) order[i] = static_cast<uint32_t>(count - 1 - i);
  }
  if (is_reverse) return;
  for (uint32_t& index : order) archive(index);
  if constexpr (Archive::kIsReader) {
    std::vector<uint32_t> sorted = order;
    std::sort(sorted.begin(), sorted.end());
    for (size_t i = 0; i < count; ++i) {
      if (sorted[i] != i) Archive::Fail();
    }
  }
}

/// Writes or reads the walls that Box2D has for a body.
template <class Archive>
void SerializeNearby(Archive& archive, BodyRecord::Nearby& nearby,
                     const std::vector<std::unique_ptr<NearbyWalls>>& layers) {
  archive(nearby.is_current, nearby.center, nearby.room, nearby.blocks);
  for (const auto& [layer, number] : nearby.blocks) {
    if (layer >= layers.size() || !layers[layer]->IsBlock(number)) Reader::Fail();
  }
}

}  // namespace

WorldState WorldState::Of(const World& world) {
  WorldState state;
  state.inverse_step = box2d::InverseStep(*world.world_);
  state.has_new_contacts = box2d::NewContacts(*world.world_);
  std::vector<uint32_t> order(world.bodies_.slot_count());  // by the index of a handle
  world.bodies_.ForEach([&](World::Body handle, const BodyRecord& record) {
    order[handle.index] = static_cast<uint32_t>(state.bodies.size());
    state.bodies.push_back(StateOf(record, *world.layers_));
  });
  world.joints_.ForEach(
      [&](World::Joint, b2Joint* joint) { state.joints.push_back(StateOf(*joint)); });
  for (b2Contact* c = world.world_->GetContactList(); c != nullptr; c = c->GetNext()) {
    const auto end_of = [&](b2Fixture& fixture) {
      return ContactState::End{order[fixture.GetBody()->GetUserData().pointer],
                               static_cast<uint32_t>(fixture.GetUserData().pointer)};
    };
    using Internals = box2d::ContactInternals;
    const bool needs_filtering = (Internals::Flags(*c) & Internals::kToFilter) != 0;
    state.contacts.push_back({end_of(*c->GetFixtureA()), end_of(*c->GetFixtureB()), c->IsTouching(),
                              c->IsEnabled(), needs_filtering, c->GetFriction(),
                              c->GetRestitution(), c->GetTangentSpeed(), *c->GetManifold()});
  }
  state.mechanisms = world.mechanisms_;
  state.crowds = world.crowds_;
  state.tree = SavedTree::Of(*world.world_, FixturesOf(world.bodies_, *world.layers_));
  return state;
}

template <class Archive>
void WorldState::Serialize(Archive& archive, const World& world) {
  archive.Same(kFormat, "its format");
  archive(inverse_step, has_new_contacts);
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
  const auto& layers = world.layers_->all();
  archive.Same(static_cast<uint32_t>(layers.size()), "the number of layers");
  std::set<std::pair<uint32_t, uint32_t>> held;  // blocks of walls
  size_t fixture_count = 0;
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
    if (records[i]->is_layer) continue;
    fixture_count += fixtures;
    SerializeOrder(archive, body.order, fixtures);
    body.boxes.resize(fixtures);
    for (b2AABB& box : body.boxes) archive(box.lowerBound, box.upperBound);
    if (!layers.empty()) SerializeNearby(archive, body.nearby, layers);
    for (const auto& [layer, number] : body.nearby.blocks) held.insert({layer, number});
  }
  for (const auto& [layer, number] : held) fixture_count += layers[layer]->CountWalls(number);
  archive.Same(static_cast<uint32_t>(joints.size()), "the number of joints");
  size_t joint_index = 0;
  world.joints_.ForEach([&](World::Joint, const b2Joint* joint) {
    archive.Same(joint->GetType(), "the type of a joint");
    archive(joints[joint_index++]);
  });
  archive(contacts);
  if constexpr (Archive::kIsReader) {
    for (const ContactState& contact : contacts) {
      if (contact.a.body == contact.b.body) Archive::Fail();
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
  SerializeMounted(archive, mechanisms.cars, order, "the number of Ackermann drives");
  SerializeMounted(archive, mechanisms.tweens, order, "the number of tweens");
  SerializeDrifts(archive, mechanisms.drifts, order);
  archive.Same(static_cast<uint32_t>(crowds.size()), "the number of crowds");
  crowds.ForEach([&](auto, Crowd& crowd) {
    archive.Same(static_cast<uint32_t>(crowd.size()), "the number of people of a crowd");
    crowd.ForEachPart([&](auto& part) { archive(part); });
    if constexpr (Archive::kIsReader) {
      if (!crowd.IsValid()) Archive::Fail();
    }
  });
  archive(tree);
  if constexpr (Archive::kIsReader) {
    if (!tree.IsSound(fixture_count)) Archive::Fail();
  }
}

std::string WorldState::Write(const World& world) {
  Writer writer;
  Serialize(writer, world);
  std::string bytes = std::move(writer).bytes();
  const uint64_t sum = Checksum(bytes);
  return bytes.append(reinterpret_cast<const char*>(&sum), sizeof sum);
}

WorldState WorldState::Read(std::string_view bytes, const World& world) {
  // Damaged numbers may pass all checks, and let an assertion of Box2D fail some steps later. So
  // the checksum comes first.
  uint64_t sum = 0;
  if (bytes.size() < sizeof sum) Reader::Fail();
  const std::string_view content = bytes.substr(0, bytes.size() - sizeof sum);
  std::memcpy(&sum, bytes.data() + content.size(), sizeof sum);
  if (sum != Checksum(content)) Reader::Fail();
  WorldState state = WorldState::Of(world);
  Reader reader(content);
  state.Serialize(reader, world);
  if (reader.remaining() > 0) Reader::Fail();
  return state;
}

std::string World::SaveState() const {
  const AccessGuard guard(*this);
  return WorldState::Of(*this).Write(*this);
}

void World::RestoreState(std::string_view bytes) {
  const AccessGuard guard(*this);
  WorldState::Read(bytes, *this).Restore(*this);
}

bool WorldState::IsApartFromWalls() const {
  return contacts.empty() && std::all_of(bodies.begin(), bodies.end(), [](const BodyState& body) {
           return body.nearby.blocks.empty();
         });
}

void WorldState::RequireSameStill(const World& world) const {
  std::vector<int32> leaves(tree.nodes.size());  // by the number of the fixture
  for (int32 leaf = 0; leaf < tree.node_count(); ++leaf) {
    if (tree.nodes[leaf].is_leaf()) leaves[tree.nodes[leaf].child2] = leaf;
  }
  size_t i = 0, fixture = 0;
  world.bodies_.ForEach([&](auto, const BodyRecord& record) {
    const BodyState& state = bodies[i++];
    const BodyState present = StateOf(record, *world.layers_);
    Require(present.materials == state.materials && present.order == state.order,
            "the state is of another world: other friction, restitution or footprints");
    for (const BodyRecord::FixtureRecord& each : record.fixtures) {
      const int32 leaf = box2d::FixtureInternals::Proxies(*each.fixture)->proxyId;
      Require(record.may_move || leaf == leaves[fixture],
              "the state is of another world: static bodies were added at other times");
      ++fixture;
    }
    Require(
        record.may_move || (present.position == state.position && present.sweep.a == state.sweep.a),
        "the state is of another world: a static body is elsewhere");
  });
}

void WorldState::Clear(World& world) {
  EndContacts(*world.world_);
  world.bodies_.ForEach(
      [&](auto, BodyRecord& record) { world.layers_->ReleaseWallsNear(*world.world_, record); });
}

void WorldState::Restore(World& world) const {
  b2World& box2d_world = *world.world_;
  EndContacts(box2d_world);
  std::vector<BodyRecord*> records;
  records.reserve(bodies.size());
  world.bodies_.ForEach([&](World::Body handle, BodyRecord& record) {
    const BodyState& state = bodies[records.size()];
    records.push_back(&record);
    if (NearbyWalls* layer = world.layers_->NearbyOf(record)) {
      layer->SetMaterials(state.materials);
    } else {
      RestoreFixtures(record, state);
    }
    const bool stays =
        record.body->GetPosition() == state.position && record.body->GetAngle() == state.sweep.a;
    if (!stays) world.bodies_.AllowMotion(handle);
  });
  for (size_t i = 0; i < records.size(); ++i) {
    world.layers_->HoldWallsOf(box2d_world, *records[i], bodies[i].nearby);
  }
  tree.Restore(box2d_world, FixturesOf(world.bodies_, *world.layers_));
  size_t joint_index = 0;
  world.joints_.ForEach(
      [&](World::Joint, b2Joint* joint) { RestoreJoint(*joint, joints[joint_index++]); });
  RestoreMechanisms(world.mechanisms_, mechanisms);
  for (auto contact = contacts.rbegin(); contact != contacts.rend(); ++contact) {
    b2Fixture* const a =
        world.layers_->FixtureOrNull(*records[contact->a.body], contact->a.fixture);
    b2Fixture* const b =
        world.layers_->FixtureOrNull(*records[contact->b.body], contact->b.fixture);
    // A wall that Box2D does not have is too far away to be touched.
    if (a != nullptr && b != nullptr) MakeContact(box2d_world, *a, *b, *contact);
  }
  for (size_t i = 0; i < records.size(); ++i) RestoreMotion(*records[i]->body, bodies[i]);
  box2d::InverseStep(box2d_world) = inverse_step;
  box2d::NewContacts(box2d_world) = has_new_contacts;
  world.contacts_.ChooseReports();
  world.crowds_.ForEach([&](auto handle, Crowd& crowd) {
    crowd.Take(crowds.Get(handle));
    crowd.Restore(world.bodies_);
  });
  world.bodies_.ChangePoses();
}

}  // namespace flatland
