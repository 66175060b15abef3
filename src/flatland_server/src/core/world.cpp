#include "flatland_server/world.hpp"

#include <algorithm>
#include <limits>
#include <stdexcept>
#include <string>

#include "box2d_limits.hpp"
#include "mover_scan.hpp"

namespace flatland {
namespace {

b2Vec2 ToBox2D(Vec2 v) { return {static_cast<float>(v.x), static_cast<float>(v.y)}; }
Vec2 FromBox2D(b2Vec2 v) { return {v.x, v.y}; }

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

/// Marks the world as in use for as long as it lives.
class BusyGuard {
 public:
  explicit BusyGuard(std::atomic<bool>& busy) : busy_(busy) {
    if (busy_.exchange(true)) throw std::logic_error("the world is in use by another thread");
  }
  ~BusyGuard() { busy_ = false; }
  BusyGuard(const BusyGuard&) = delete;
  BusyGuard& operator=(const BusyGuard&) = delete;

 private:
  std::atomic<bool>& busy_;
};

}  // namespace

World::World(int velocity_iterations, int position_iterations)
    : world_(b2Vec2_zero),
      velocity_iterations_(velocity_iterations),
      position_iterations_(position_iterations) {
  Require(velocity_iterations >= 1 && position_iterations >= 1,
          "a solver needs at least one iteration");
  world_.SetDestructionListener(this);
}

void World::RequireIdle() const {
  if (busy_) throw std::logic_error("the world is in use by another thread");
}

b2Body& World::Find(Body body) const {
  RequireIdle();
  return *bodies_.Get(body);
}

void World::AddLayer(const std::vector<Segment>& segments, LayerBits layers) {
  for (const Segment& segment : segments) {
    RequirePlace(segment.a);
    RequirePlace(segment.b);
    Require(segment.a.x != segment.b.x || segment.a.y != segment.b.y,
            "a wall's ends must not be one point");
  }
  const BusyGuard guard(busy_);
  const b2BodyDef definition;
  b2Body* body = world_.CreateBody(&definition);
  b2FixtureDef fixture;
  fixture.filter.categoryBits = layers;
  fixture.filter.maskBits = layers;
  for (const Segment& segment : segments) {
    b2EdgeShape edge;
    edge.SetTwoSided(ToBox2D(segment.a), ToBox2D(segment.b));
    fixture.shape = &edge;
    body->CreateFixture(&fixture);
  }
  layers_.push_back({std::make_shared<const SegmentGrid>(segments), layers});
}

World::Body World::AddBody(const BodySettings& settings) {
  RequirePlace({settings.pose.x, settings.pose.y});
  Require(IsUsable(settings.pose.yaw), "a heading must be finite");
  RequireNotNegative(settings.linear_damping, "linear_damping must be finite and not negative");
  RequireNotNegative(settings.angular_damping, "angular_damping must be finite and not negative");
  const BusyGuard guard(busy_);
  b2BodyDef definition;
  definition.type = settings.type;
  definition.position = ToBox2D({settings.pose.x, settings.pose.y});
  definition.angle = static_cast<float>(settings.pose.yaw);
  definition.linearDamping = static_cast<float>(settings.linear_damping);
  definition.angularDamping = static_cast<float>(settings.angular_damping);
  return bodies_.Add(world_.CreateBody(&definition));
}

void World::RemoveBody(Body body) {
  b2Body& gone = Find(body);
  const BusyGuard guard(busy_);
  std::vector<Drive> its_drives;
  drives_.ForEach([&](Drive drive, const DrivenBody& driven) {
    if (driven.body.index == body.index) its_drives.push_back(drive);
  });
  for (Drive drive : its_drives) drives_.Remove(drive);
  bodies_.Remove(body);
  world_.DestroyBody(&gone);
}

void World::SayGoodbye(b2Joint* joint) {
  joints_.ForEach([&](Joint handle, b2Joint* candidate) {
    if (candidate == joint) joints_.Remove(handle);
  });
}

void World::AddFixture(b2Body& body, const b2Shape& shape, const FixtureSettings& settings) {
  Require(
      settings.density == 0.0 || (IsUsable(settings.density) && settings.density >= kLeastDensity),
      "density must be 0, or finite and 1e-6 kg/m^2 at least");
  RequireNotNegative(settings.friction, "friction must be finite and not negative");
  RequireNotNegative(settings.restitution, "restitution must be finite and not negative");
  Require(HasInertia(body, shape, static_cast<float>(settings.density)),
          "a footprint is too small for its distance from the body's origin");
  const BusyGuard guard(busy_);
  b2FixtureDef definition;
  definition.shape = &shape;
  definition.density = static_cast<float>(settings.density);
  definition.friction = static_cast<float>(settings.friction);
  definition.restitution = static_cast<float>(settings.restitution);
  definition.isSensor = settings.sensor;
  definition.filter.categoryBits = settings.layers;
  definition.filter.maskBits = settings.collides ? settings.layers : 0;
  body.CreateFixture(&definition);
}

void World::AddCircle(Body body, Vec2 center, double radius, const FixtureSettings& settings) {
  RequirePlace(center);
  Require(radius >= kLeastRadius && radius <= kFarthest, "a radius must be 0.1 mm to 100 km");
  b2CircleShape shape;
  shape.m_p = ToBox2D(center);
  shape.m_radius = static_cast<float>(radius);
  AddFixture(Find(body), shape, settings);
}

void World::AddPolygon(Body body, const std::vector<Vec2>& vertices,
                       const FixtureSettings& settings) {
  Require(vertices.size() >= 3 && vertices.size() <= b2_maxPolygonVertices,
          "a polygon needs 3 to 8 vertices");
  for (const Vec2& vertex : vertices) RequirePlace(vertex);
  std::vector<b2Vec2> points;
  for (const Vec2& vertex : vertices) points.push_back(ToBox2D(vertex));
  Require(HasHull(points), "a polygon is too small or too thin: its corners fall together");
  b2PolygonShape shape;
  shape.Set(points.data(), static_cast<int32>(points.size()));
  AddFixture(Find(body), shape, settings);
}

World::Joint World::AddJoint(const b2JointDef& definition) {
  Require(definition.bodyA != definition.bodyB, "a joint needs two bodies");
  const BusyGuard guard(busy_);
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

double World::JointAngle(Joint joint) const {
  RequireIdle();
  b2Joint* found = joints_.Get(joint);
  double angle = found->GetBodyB()->GetAngle() - found->GetBodyA()->GetAngle();
  if (found->GetType() == e_weldJoint) {
    angle -= static_cast<b2WeldJoint*>(found)->GetReferenceAngle();
  }
  return std::remainder(angle, 2.0 * M_PI);
}

World::Drive World::AddDrive(Body body, const DynamicsLimits& linear,
                             const DynamicsLimits& angular) {
  Find(body);
  return drives_.Add({body, BodyDrive(linear, angular)});
}

BodyDrive& World::GetDrive(Drive drive) {
  RequireIdle();
  return drives_.Get(drive).drive;
}

Pose World::GetPose(Body body) const {
  const b2Body& found = Find(body);
  const Vec2 position = FromBox2D(found.GetPosition());
  return {position.x, position.y, found.GetAngle()};
}

void World::SetPose(Body body, const Pose& pose) {
  RequirePlace({pose.x, pose.y});
  Require(IsUsable(pose.yaw), "a heading must be finite");
  b2Body& found = Find(body);
  // Of the angles that are the same heading, the one near the present angle: a joint would feel a
  // whole turn that only one of its bodies makes. Half a turn either way is taken as it is given.
  constexpr double kSlack = 1e-3;
  double turn = pose.yaw - found.GetAngle();
  if (std::abs(turn) > M_PI + kSlack) turn = std::remainder(turn, 2.0 * M_PI);
  const Twist velocity = GetVelocity(body);
  found.SetTransform(ToBox2D({pose.x, pose.y}), static_cast<float>(found.GetAngle() + turn));
  SetVelocity(body, velocity);  // Box2D keeps that of the centre of mass, not of the origin
  found.SetAwake(true);
}

Twist World::GetVelocity(Body body) const {
  const b2Body& found = Find(body);
  const Vec2 velocity = FromBox2D(found.GetLinearVelocityFromLocalPoint(b2Vec2_zero));
  return {velocity.x, velocity.y, found.GetAngularVelocity()};
}

void World::SetVelocity(Body body, const Twist& velocity) {
  Require(IsUsable(velocity), "a velocity must be finite");
  b2Body& found = Find(body);
  const Vec2 arm = Rotation(found.GetAngle()).Apply(FromBox2D(found.GetLocalCenter()));
  found.SetLinearVelocity(
      ToBox2D({velocity.vx - velocity.omega * arm.y, velocity.vy + velocity.omega * arm.x}));
  found.SetAngularVelocity(static_cast<float>(velocity.omega));
}

Twist World::GetLocalVelocity(Body body) const {
  const b2Body& found = Find(body);
  const double omega = found.GetAngularVelocity();
  const Rotation halfway(found.GetAngle() - 0.5 * omega * last_dt_);
  const Vec2 of_center = halfway.ApplyInverse(FromBox2D(found.GetLinearVelocity()));
  const Vec2 arm = FromBox2D(found.GetLocalCenter());
  return {of_center.x + omega * arm.y, of_center.y - omega * arm.x, omega};
}

void World::Halt(Body body) {
  b2Body& found = Find(body);
  found.SetLinearVelocity(b2Vec2_zero);
  found.SetAngularVelocity(0.0f);
  drives_.ForEach([&](Drive, DrivenBody& driven) {
    if (driven.body.index == body.index) driven.drive.Reset();
  });
}

double World::GetMass(Body body) const { return Find(body).GetMass(); }

void World::ApplyForce(Body body, Vec2 force, double torque) {
  Require(IsUsable(force) && IsUsable(torque), "a force must be finite");
  b2Body& found = Find(body);
  found.ApplyForceToCenter(ToBox2D(force), true);
  found.ApplyTorque(static_cast<float>(torque), true);
}

void World::Step(double dt) {
  Require(IsUsable(dt) && dt >= kLeastStep, "a step must be finite and longer than zero");
  const BusyGuard guard(busy_);
  drives_.ForEach(
      [&](Drive, DrivenBody& driven) { driven.drive.Apply(*bodies_.Get(driven.body), dt); });
  world_.Step(static_cast<float>(dt), velocity_iterations_, position_iterations_);
  bodies_.ForEach([](Body, b2Body* body) { Unwind(*body); });
  last_dt_ = dt;
}

void World::Scan(const BeamFan& fan, const Pose& pose, const ScanSettings& settings, float* ranges,
                 float* intensities) const {
  Require(IsUsable(pose), "a lidar's pose must be finite");
  Require(IsUsable(settings.range) && settings.range > 0.0,
          "a lidar's range must be finite and above zero");
  const BusyGuard guard(busy_);
  const Vec2 origin{pose.x, pose.y};
  const Rotation rotation(pose.yaw);
  std::fill_n(ranges, fan.size(), std::numeric_limits<float>::infinity());
  std::fill_n(intensities, fan.size(), 0.0f);
  const auto intensity = [&](LayerBits layers) {
    return (layers & settings.reflectance_layers) != 0 ? 255.0f : 0.0f;
  };

  for (const Layer& layer : layers_) {
    if ((layer.bits & settings.layers) == 0) continue;
    for (int beam = 0; beam < fan.size(); ++beam) {
      const double limit = std::min<double>(ranges[beam], settings.range);
      const double distance = layer.grid->Cast(origin, rotation.Apply(fan.direction(beam)), limit);
      if (distance < ranges[beam]) {
        ranges[beam] = static_cast<float>(distance);
        intensities[beam] = intensity(layer.bits);
      }
    }
  }

  bodies_.ForEach([&](Body, const b2Body* body) {
    for (const b2Fixture* f = body->GetFixtureList(); f != nullptr; f = f->GetNext()) {
      const LayerBits layers = f->GetFilterData().categoryBits;
      if (f->IsSensor() || (layers & settings.layers) == 0) continue;
      const Mover mover(*f, pose);
      if (mover.distance() > settings.range) continue;
      fan.ForEachBeamNear(mover.bearing(), mover.half_width(), [&](int beam) {
        const double distance = mover.Cast(fan.direction(beam));
        if (distance <= settings.range && distance < ranges[beam]) {
          ranges[beam] = static_cast<float>(distance);
          intensities[beam] = intensity(layers);
        }
      });
    }
  });
}

}  // namespace flatland
