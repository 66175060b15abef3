#include "flatland_server/world.hpp"

#include <algorithm>
#include <stdexcept>
#include <string>

#include "box2d_limits.hpp"
#include "to_box2d.hpp"

namespace flatland {
namespace {

constexpr char kLayerStays[] = "a layer stays where it is";
constexpr char kBusy[] = "the world is in use by another thread";
constexpr char kLocked[] =
    "nothing is added, removed, put elsewhere or scanned while contacts are told of; wait for the "
    "end of the step";

/// Box2D counts a body's turns in single precision: after an hour of spinning, a step's turn would
/// be lost in rounding. This takes whole turns off a body, and off all whose angle a joint compares
/// with its own: not across a hinge without limits, where they may differ by any number of turns.
void Unwind(b2Body& body) {
  constexpr float kTurn = 2.0f * b2_pi;
  if (std::abs(body.GetAngle()) <= kTurn) return;
  const float turns = std::round(body.GetAngle() / kTurn) * kTurn;
  std::vector<b2Body*> group{&body};
  for (size_t i = 0; i < group.size(); ++i) {
    b2Body& member = *group[i];
    member.SetTransform(member.GetPosition(), member.GetAngle() - turns);
    for (b2JointEdge* edge = member.GetJointList(); edge != nullptr; edge = edge->next) {
      const bool compares = edge->joint->GetType() != e_revoluteJoint ||
                            static_cast<b2RevoluteJoint*>(edge->joint)->IsLimitEnabled();
      const bool is_new = std::find(group.begin(), group.end(), edge->other) == group.end();
      if (compares && is_new) group.push_back(edge->other);
    }
  }
}

}  // namespace

World::World(int velocity_iterations, int position_iterations)
    : world_(b2Vec2_zero),
      velocity_iterations_(velocity_iterations),
      position_iterations_(position_iterations) {
  Require(velocity_iterations >= 1 && position_iterations >= 1,
          "a solver needs at least one iteration");
  world_.SetDestructionListener(this);
}

bool World::IsListening() const { return listening_thread_ == std::this_thread::get_id(); }

void World::RequireAccess() const {
  if (busy_ && !IsListening()) throw std::logic_error(kBusy);
}

void World::Begin() const {
  if (busy_.exchange(true)) throw std::logic_error(IsListening() ? kLocked : kBusy);
}

b2Body& World::Find(Body body) const {
  RequireAccess();
  return *bodies_.Get(body).body;
}

World::Body World::AddLayer(const std::vector<Segment>& segments, LayerBits layers) {
  for (const Segment& segment : segments) {
    RequirePlace(segment.a);
    RequirePlace(segment.b);
    Require(segment.a.x != segment.b.x || segment.a.y != segment.b.y,
            "a wall's ends must not be one point");
  }
  const Turn turn(*this);
  const b2BodyDef definition;
  BodyRecord record;
  record.body = world_.CreateBody(&definition);
  record.is_layer = true;
  record.fixtures.reserve(segments.size());
  b2FixtureDef fixture;
  fixture.filter.categoryBits = layers;
  fixture.filter.maskBits = layers;
  for (const Segment& segment : segments) {
    b2EdgeShape edge;
    edge.SetTwoSided(ToBox2D(segment.a), ToBox2D(segment.b));
    fixture.shape = &edge;
    fixture.userData.pointer = record.fixtures.size();
    record.fixtures.push_back({record.body->CreateFixture(&fixture), false, 0.0});
  }
  layers_.push_back({SegmentTree::Share(segments), layers});
  ++state_;
  b2Body* body = record.body;
  const Body handle = bodies_.Add(std::move(record));
  body->GetUserData().pointer = handle.index;
  return handle;
}

World::Body World::AddBody(const BodySettings& settings) {
  RequirePlace({settings.pose.x, settings.pose.y});
  Require(IsUsable(settings.pose.yaw), "a heading must be finite");
  RequireNotNegative(settings.linear_damping, "linear_damping must be finite and not negative");
  RequireNotNegative(settings.angular_damping, "angular_damping must be finite and not negative");
  const Turn turn(*this);
  b2BodyDef definition;
  definition.type = settings.type;
  definition.position = ToBox2D({settings.pose.x, settings.pose.y});
  definition.angle = static_cast<float>(settings.pose.yaw);
  definition.linearDamping = static_cast<float>(settings.linear_damping);
  definition.angularDamping = static_cast<float>(settings.angular_damping);
  BodyRecord record;
  record.body = world_.CreateBody(&definition);
  b2Body* body = record.body;
  const Body handle = bodies_.Add(std::move(record));
  body->GetUserData().pointer = handle.index;
  return handle;
}

void World::RemoveBody(Body body) {
  const Turn turn(*this);
  BodyRecord& record = bodies_.Get(body);
  Require(!record.is_layer, "a layer is there for good");
  const auto remove_from = [body](auto& map) {
    ForEachOf(map, body, [&](auto handle, auto&) { map.Remove(handle); });
  };
  remove_from(drives_);
  remove_from(tricycles_);
  remove_from(tweens_);
  remove_from(lidars_);
  ++state_;
  world_.DestroyBody(record.body);  // its contacts end, which the listener hears of
  bodies_.Remove(body);
  ApplyLateForces();
}

void World::SayGoodbye(b2Joint* joint) {
  tricycles_.ForEach([&](Tricycle, Moved<TricycleDrive>& moved) { moved.mechanism.Forget(joint); });
  joints_.ForEach([&](Joint handle, b2Joint* candidate) {
    if (candidate == joint) joints_.Remove(handle);
  });
}

Fixture World::AddFixture(Body handle, const b2Shape& shape, const FixtureSettings& settings) {
  b2Body& body = Find(handle);
  Require(!bodies_.Get(handle).is_layer, "a layer consists of walls alone");
  Require(
      settings.density == 0.0 || (IsUsable(settings.density) && settings.density >= kLeastDensity),
      "density must be 0, or finite and 1e-6 kg/m^2 at least");
  RequireNotNegative(settings.friction, "friction must be finite and not negative");
  RequireNotNegative(settings.restitution, "restitution must be finite and not negative");
  Require(HasInertia(body, shape, static_cast<float>(settings.density)),
          "a footprint is too small for its distance from the body's origin");
  const Turn turn(*this);
  auto& fixtures = bodies_.Get(handle).fixtures;
  b2FixtureDef definition;
  definition.userData.pointer = fixtures.size();
  definition.shape = &shape;
  definition.density = static_cast<float>(settings.density);
  definition.friction = static_cast<float>(settings.friction);
  definition.restitution = static_cast<float>(settings.restitution);
  definition.isSensor = settings.sensor;
  definition.filter.categoryBits = settings.layers;
  definition.filter.maskBits = settings.collides ? settings.layers : 0;
  fixtures.push_back({body.CreateFixture(&definition), settings.visible, ReachOf(shape)});
  ++state_;
  return {handle, static_cast<uint32_t>(fixtures.size() - 1)};
}

Fixture World::AddCircle(Body body, Vec2 center, double radius, const FixtureSettings& settings) {
  RequirePlace(center);
  Require(radius >= kLeastRadius && radius <= kFarthest, "a radius must be 0.1 mm to 100 km");
  b2CircleShape shape;
  shape.m_p = ToBox2D(center);
  shape.m_radius = static_cast<float>(radius);
  return AddFixture(body, shape, settings);
}

Fixture World::AddPolygon(Body body, const std::vector<Vec2>& vertices,
                          const FixtureSettings& settings) {
  Require(vertices.size() >= 3 && vertices.size() <= b2_maxPolygonVertices,
          "a polygon needs 3 to 8 vertices");
  for (const Vec2& vertex : vertices) RequirePlace(vertex);
  std::vector<b2Vec2> points;
  for (const Vec2& vertex : vertices) points.push_back(ToBox2D(vertex));
  Require(HasHull(points), "a polygon is too small or too thin: its corners fall together");
  b2PolygonShape shape;
  shape.Set(points.data(), static_cast<int32>(points.size()));
  return AddFixture(body, shape, settings);
}

World::Joint World::AddJoint(const b2JointDef& definition) {
  Require(definition.bodyA != definition.bodyB, "a joint needs two bodies");
  const Turn turn(*this);
  return joints_.Add(world_.CreateJoint(&definition));
}

World::Joint World::AddRevolute(Body a, Body b, const RevoluteSettings& settings) {
  RequirePlace(settings.anchor_a);
  RequirePlace(settings.anchor_b);
  b2RevoluteJointDef definition;
  definition.bodyA = &Find(a);
  definition.bodyB = &Find(b);
  definition.localAnchorA = ToBox2D(settings.anchor_a);
  definition.localAnchorB = ToBox2D(settings.anchor_b);
  definition.collideConnected = settings.collide_connected;
  if (settings.limits) {
    const auto [lower, upper] = *settings.limits;
    Require(IsUsable(lower) && IsUsable(upper) && lower <= upper,
            "a joint's limits must be finite, the lower one first");
    definition.enableLimit = true;
    definition.lowerAngle = static_cast<float>(lower);
    definition.upperAngle = static_cast<float>(upper);
  }
  return AddJoint(definition);
}

World::Joint World::AddWeld(Body a, Body b, const WeldSettings& settings) {
  RequirePlace(settings.anchor_a);
  RequirePlace(settings.anchor_b);
  Require(IsUsable(settings.angle), "a weld's angle must be finite");
  RequireNotNegative(settings.frequency, "a weld's frequency must be finite and not negative");
  RequireNotNegative(settings.damping, "a weld's damping must be finite and not negative");
  b2WeldJointDef definition;
  definition.bodyA = &Find(a);
  definition.bodyB = &Find(b);
  definition.localAnchorA = ToBox2D(settings.anchor_a);
  definition.localAnchorB = ToBox2D(settings.anchor_b);
  definition.referenceAngle = static_cast<float>(settings.angle);
  definition.collideConnected = settings.collide_connected;
  if (settings.frequency > 0.0) {
    b2AngularStiffness(definition.stiffness, definition.damping,
                       static_cast<float>(settings.frequency), static_cast<float>(settings.damping),
                       definition.bodyA, definition.bodyB);
  }
  return AddJoint(definition);
}

World::Drive World::AddDrive(Body body, const DynamicsLimits& linear,
                             const DynamicsLimits& angular) {
  Find(body);
  const Turn turn(*this);
  Require(!bodies_.Get(body).is_layer, kLayerStays);
  return drives_.Add({body, BodyDrive(linear, angular)});
}

World::Tricycle World::AddTricycle(Body body, Joint front_wheel, const TricycleSettings& settings) {
  const b2Body& base = Find(body);
  const Turn turn(*this);
  b2Joint* joint = joints_.Get(front_wheel);
  Require(joint->GetType() == e_revoluteJoint &&
              (joint->GetBodyA() == &base || joint->GetBodyB() == &base),
          "the front wheel's joint must be a revolute joint of the driven body");
  return tricycles_.Add({body, TricycleDrive(settings, static_cast<b2RevoluteJoint*>(joint))});
}

World::Tween World::AddTween(Body body, const TweenSettings& settings) {
  const Pose start = GetPose(body);
  const Turn turn(*this);
  Require(!bodies_.Get(body).is_layer, kLayerStays);
  return tweens_.Add({body, BodyTween(settings, start)});
}

void World::Place(b2Body& body, const Pose& pose) {
  // Of the angles that are the same heading, the one near the present angle: a joint would feel a
  // whole turn that only one of its bodies makes. Half a turn either way is taken as it is given.
  constexpr double kSlack = 1e-3;
  double turn = pose.yaw - body.GetAngle();
  if (std::abs(turn) > M_PI + kSlack) turn = std::remainder(turn, 2.0 * M_PI);
  body.SetTransform(ToBox2D({pose.x, pose.y}), static_cast<float>(body.GetAngle() + turn));
}

void World::Step(double dt, const Turn&) {
  Require(IsUsable(dt) && dt >= kLeastStep, "a step must be finite and longer than zero");
  ++state_;
  const auto for_each = [this](auto& map, auto visit) {
    map.ForEach([&](auto, auto& moved) { visit(moved.mechanism, *bodies_.Get(moved.body).body); });
  };
  const auto begin = [dt](auto& drive, b2Body& body) { drive.BeginStep(body, dt); };
  const auto end = [](auto& drive, b2Body& body) { drive.EndStep(body); };
  for_each(drives_, begin);
  for_each(tricycles_, begin);
  for_each(tweens_, [&](BodyTween& tween, b2Body& body) {
    const Pose from = tween.target();
    const Pose to = tween.Advance(dt);
    const bool jumps = tween.teleports();
    // The solver sees the body move; the pose of the end is exact all the same.
    const Twist velocity =
        jumps ? Twist{}
              : Twist{(to.x - body.GetPosition().x) / dt, (to.y - body.GetPosition().y) / dt,
                      (to.yaw - from.yaw) / dt};
    SetOriginVelocity(body, velocity);
  });
  world_.Step(static_cast<float>(dt), velocity_iterations_, position_iterations_);
  for_each(drives_, end);
  for_each(tricycles_, end);
  for_each(tweens_, [&](BodyTween& tween, b2Body& body) {
    const double omega = body.GetAngularVelocity();
    const Vec2 of_center = FromBox2D(body.GetLinearVelocity());
    const Vec2 arm = Rotation(body.GetAngle() - omega * dt).Apply(FromBox2D(body.GetLocalCenter()));
    Place(body, tween.target());
    SetOriginVelocity(body, {of_center.x + omega * arm.y, of_center.y - omega * arm.x, omega});
    WakeThoseNear(body);
  });
  bodies_.ForEach([](Body, BodyRecord& record) { Unwind(*record.body); });
  ApplyLateForces();
}

}  // namespace flatland
