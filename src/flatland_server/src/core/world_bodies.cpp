/// What may be asked of a World's bodies, fixtures and joints, and done to them, one at a time.

#include <stdexcept>

#include "box2d_limits.hpp"
#include "flatland_server/world.hpp"
#include "to_box2d.hpp"

namespace flatland {

double World::JointAngle(Joint joint) const {
  RequireAccess();
  b2Joint* found = joints_.Get(joint);
  double angle = found->GetBodyB()->GetAngle() - found->GetBodyA()->GetAngle();
  if (found->GetType() == e_weldJoint) {
    angle -= static_cast<b2WeldJoint*>(found)->GetReferenceAngle();
  }
  return std::remainder(angle, 2.0 * M_PI);
}

Pose World::GetPose(Body body) const { return PoseOf(Find(body)); }

Pose World::GetPoseIn(Body reference, Body body) const {
  const Pose from = GetPose(reference);
  const Pose to = GetPose(body);
  const double yaw = std::remainder(from.yaw, 2.0 * M_PI);
  const Vec2 place = Rotation(yaw).ApplyInverse(Vec2{to.x, to.y} - Vec2{from.x, from.y});
  return {place.x, place.y, std::remainder(to.yaw, 2.0 * M_PI) - yaw};
}

void World::SetPose(Body body, const Pose& pose) {
  RequirePlace({pose.x, pose.y});
  Require(IsUsable(pose.yaw), "a heading must be finite");
  b2Body& found = Find(body);
  const Twist velocity = GetVelocity(body);
  const Turn turn(*this);
  Require(!bodies_.Get(body).is_layer, "a layer stays where it is");
  ++state_;
  WakeThoseNear(found);
  Place(found, pose);
  WakeThoseNear(found);
  SetOriginVelocity(found, velocity);
  found.SetAwake(true);
  ForEachOf(tweens_, body, [&](Tween, BodyTween& tween) { tween.Rebase(PoseOf(found)); });
}

void World::WakeThoseNear(const b2Body& body) {
  if (body.GetType() != b2_staticBody) return;
  struct Waker : b2QueryCallback {
    bool ReportFixture(b2Fixture* fixture) override {
      fixture->GetBody()->SetAwake(true);
      return true;
    }
  } waker;
  for (const b2Fixture* f = body.GetFixtureList(); f != nullptr; f = f->GetNext()) {
    world_.QueryAABB(&waker, f->GetAABB(0));
  }
}

Twist World::GetVelocity(Body body) const {
  const b2Body& found = Find(body);
  const Vec2 velocity = FromBox2D(found.GetLinearVelocityFromLocalPoint(b2Vec2_zero));
  return {velocity.x, velocity.y, found.GetAngularVelocity()};
}

void World::SetVelocity(Body body, const Twist& velocity) {
  Require(IsUsable(velocity), "a velocity must be finite");
  SetOriginVelocity(Find(body), velocity);
}

Twist World::GetLocalVelocity(Body body) const {
  const b2Body& found = Find(body);
  const double omega = found.GetAngularVelocity();
  const Vec2 of_center =
      Rotation(found.GetAngle()).ApplyInverse(FromBox2D(found.GetLinearVelocity()));
  const Vec2 arm = FromBox2D(found.GetLocalCenter());
  return {of_center.x + omega * arm.y, of_center.y - omega * arm.x, omega};
}

Vec2 World::GetVelocityAt(Body body, Vec2 point) const {
  RequirePlace(point);
  return FromBox2D(Find(body).GetLinearVelocityFromWorldPoint(ToBox2D(point)));
}

void World::Halt(Body body) {
  b2Body& found = Find(body);
  found.SetLinearVelocity(b2Vec2_zero);
  found.SetAngularVelocity(0.0f);
  ForEachOf(drives_, body, [](Drive, BodyDrive& drive) { drive.Reset(); });
  ForEachOf(tricycles_, body, [](Tricycle, TricycleDrive& drive) { drive.Reset(); });
}

Vec2 World::ToWorldPoint(Body body, Vec2 point) const {
  const Vec2 origin = FromBox2D(Find(body).GetPosition());
  return origin + ToWorldVector(body, point);
}

Vec2 World::ToLocalPoint(Body body, Vec2 point) const {
  return ToLocalVector(body, point - FromBox2D(Find(body).GetPosition()));
}

Vec2 World::ToWorldVector(Body body, Vec2 vector) const {
  return Rotation(Find(body).GetAngle()).Apply(vector);
}

Vec2 World::ToLocalVector(Body body, Vec2 vector) const {
  return Rotation(Find(body).GetAngle()).ApplyInverse(vector);
}

double World::GetMass(Body body) const {
  const b2Body& found = Find(body);
  return found.GetType() == b2_dynamicBody ? found.GetMass() : 0.0;
}

double World::GetInertia(Body body) const {
  const b2Body& found = Find(body);  // Box2D's is about the origin
  if (found.GetType() != b2_dynamicBody) return 0.0;
  return found.GetInertia() - found.GetMass() * found.GetLocalCenter().LengthSquared();
}

Vec2 World::GetCenter(Body body) const { return FromBox2D(Find(body).GetWorldCenter()); }

void World::ApplyForce(Body body, Vec2 force, std::optional<Vec2> point) {
  Require(IsUsable(force), "a force must be finite");
  if (point) RequirePlace(*point);
  b2Body& found = Find(body);
  if (IsListening()) {
    late_forces_.push_back({body, force, point, 0.0});
    return;
  }
  found.ApplyForce(ToBox2D(force), point ? ToBox2D(*point) : found.GetWorldCenter(), true);
}

void World::ApplyTorque(Body body, double torque) {
  Require(IsUsable(torque), "a torque must be finite");
  b2Body& found = Find(body);
  if (IsListening()) {
    late_forces_.push_back({body, {}, std::nullopt, torque});
    return;
  }
  found.ApplyTorque(static_cast<float>(torque), true);
}

void World::ApplyLateForces() {
  for (const LateForce& late : late_forces_) {
    if (!Contains(late.body)) continue;
    b2Body& body = *bodies_.Get(late.body).body;
    const b2Vec2 point = late.point ? ToBox2D(*late.point) : body.GetWorldCenter();
    body.ApplyForce(ToBox2D(late.force), point, true);
    body.ApplyTorque(static_cast<float>(late.torque), true);
  }
  late_forces_.clear();
}

void World::ApplyLinearImpulse(Body body, Vec2 impulse, std::optional<Vec2> point) {
  Require(IsUsable(impulse), "an impulse must be finite");
  b2Body& found = Find(body);
  if (point) RequirePlace(*point);
  found.ApplyLinearImpulse(ToBox2D(impulse), point ? ToBox2D(*point) : found.GetWorldCenter(),
                           true);
}

void World::ApplyAngularImpulse(Body body, double impulse) {
  Require(IsUsable(impulse), "an impulse must be finite");
  Find(body).ApplyAngularImpulse(static_cast<float>(impulse), true);
}

int World::GetFixtureCount(Body body) const {
  RequireAccess();
  return static_cast<int>(bodies_.Get(body).fixtures.size());
}

b2Fixture& World::Find(Fixture fixture) const {
  RequireAccess();
  const auto& fixtures = bodies_.Get(fixture.body).fixtures;
  Require(fixture.index < fixtures.size(), "the body has no such fixture");
  return *fixtures[fixture.index].fixture;
}

FixtureSettings World::GetSettings(Fixture fixture) const {
  const b2Fixture& found = Find(fixture);
  FixtureSettings settings;
  settings.density = found.GetDensity();
  settings.friction = found.GetFriction();
  settings.restitution = found.GetRestitution();
  settings.sensor = found.IsSensor();
  settings.collides = found.GetFilterData().maskBits != 0;
  settings.visible = bodies_.Get(fixture.body).fixtures[fixture.index].visible;
  settings.layers = found.GetFilterData().categoryBits;
  return settings;
}

void World::SetFriction(Fixture fixture, double friction) {
  RequireNotNegative(friction, "friction must be finite and not negative");
  Find(fixture).SetFriction(static_cast<float>(friction));
}

void World::SetRestitution(Fixture fixture, double restitution) {
  RequireNotNegative(restitution, "restitution must be finite and not negative");
  Find(fixture).SetRestitution(static_cast<float>(restitution));
}

bool World::TestPoint(Fixture fixture, Vec2 point) const {
  RequirePlace(point);
  return Find(fixture).TestPoint(ToBox2D(point));
}

}  // namespace flatland
