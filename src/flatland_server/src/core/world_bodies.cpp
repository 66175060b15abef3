/// World: bodies.

#include "box2d_limits.hpp"
#include "flatland_server/world.hpp"
#include "to_box2d.hpp"

namespace flatland {

b2Body& World::Find(Body body) const {
  RequireAccess();
  return *bodies_.Get(body).body;
}

World::Body World::AddRecord(BodyRecord record) {
  b2Body* body = record.body;
  const Body handle = bodies_.Add(std::move(record));
  body->GetUserData().pointer = handle.index;
  return handle;
}

World::Body World::AddBody(const BodySettings& settings) {
  RequirePosition({settings.pose.x, settings.pose.y});
  Require(IsUsable(settings.pose.yaw), "a heading must be finite");
  RequireNotNegative(settings.linear_damping, "linear_damping must be finite and not negative");
  RequireNotNegative(settings.angular_damping, "angular_damping must be finite and not negative");
  const AccessGuard guard(*this);
  b2BodyDef definition;
  definition.type = settings.type;
  definition.position = ToBox2D({settings.pose.x, settings.pose.y});
  definition.angle = static_cast<float>(settings.pose.yaw);
  definition.linearDamping = static_cast<float>(settings.linear_damping);
  definition.angularDamping = static_cast<float>(settings.angular_damping);
  BodyRecord record;
  record.body = world_->CreateBody(&definition);
  return AddRecord(std::move(record));
}

void World::RemoveBody(Body body) {
  const AccessGuard guard(*this);
  BodyRecord& record = bodies_.Get(body);
  Require(!record.is_layer, "a layer cannot be removed");
  const auto remove_from = [body](auto& map) {
    ForEachOn(body, map, [&](auto handle, auto&) { map.Remove(handle); });
  };
  remove_from(drives_);
  remove_from(tricycles_);
  remove_from(tweens_);
  remove_from(lidars_);
  ++revision_;
  world_->DestroyBody(record.body);  // ends its contacts, and calls the contact listener for them
  ReleaseWallsNear(record);
  bodies_.Remove(body);
  ApplyDeferredForces();
}

Pose World::GetPose(Body body) const { return PoseOf(Find(body)); }

Pose World::GetPoseIn(Body reference, Body body) const {
  const Pose from = GetPose(reference);
  const Pose to = GetPose(body);
  const double yaw = std::remainder(from.yaw, 2.0 * M_PI);
  const Vec2 position = Rotation(yaw).ApplyInverse(Vec2{to.x, to.y} - Vec2{from.x, from.y});
  return {position.x, position.y, std::remainder(to.yaw, 2.0 * M_PI) - yaw};
}

void World::SetPose(Body body, const Pose& pose) {
  RequirePosition({pose.x, pose.y});
  Require(IsUsable(pose.yaw), "a heading must be finite");
  b2Body& found = Find(body);
  const Twist velocity = GetVelocity(body);
  const AccessGuard guard(*this);
  Require(!bodies_.Get(body).is_layer, "a layer cannot be moved");
  ++revision_;
  WakeBodiesNear(found);
  Place(found, pose);
  WakeBodiesNear(found);
  SetOriginVelocity(found, velocity);
  found.SetAwake(true);
  ForEachOn(body, tweens_, [&](Tween, BodyTween& tween) { tween.Rebase(PoseOf(found)); });
}

// A joint would react to a whole rotation that only one of its bodies makes. A rotation by half a
// turn either way, up to rounding, is applied as given.
void World::Place(b2Body& body, const Pose& pose) {
  constexpr double kRoundingMargin = 1e-3;  // [rad]
  double rotation = pose.yaw - body.GetAngle();
  if (std::abs(rotation) > M_PI + kRoundingMargin) {
    rotation = std::remainder(rotation, 2.0 * M_PI);
  }
  body.SetTransform(ToBox2D({pose.x, pose.y}), static_cast<float>(body.GetAngle() + rotation));
}

void World::WakeBodiesNear(const b2Body& body) {
  if (body.GetType() != b2_staticBody) return;
  struct Waker : b2QueryCallback {
    bool ReportFixture(b2Fixture* fixture) override {
      fixture->GetBody()->SetAwake(true);
      return true;
    }
  } waker;
  for (const b2Fixture* f = body.GetFixtureList(); f != nullptr; f = f->GetNext()) {
    world_->QueryAABB(&waker, f->GetAABB(0));
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
  RequirePosition(point);
  return FromBox2D(Find(body).GetLinearVelocityFromWorldPoint(ToBox2D(point)));
}

void World::Halt(Body body) {
  b2Body& found = Find(body);
  found.SetLinearVelocity(b2Vec2_zero);
  found.SetAngularVelocity(0.0f);
  ForEachOn(body, drives_, [](Drive, BodyDrive& drive) { drive.Reset(); });
  ForEachOn(body, tricycles_, [](Tricycle, TricycleDrive& drive) { drive.Reset(); });
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
  const b2Body& found = Find(body);  // Box2D's inertia is about the body's origin
  if (found.GetType() != b2_dynamicBody) return 0.0;
  return found.GetInertia() - found.GetMass() * found.GetLocalCenter().LengthSquared();
}

Vec2 World::GetCenter(Body body) const { return FromBox2D(Find(body).GetWorldCenter()); }

void World::ApplyForce(Body body, Vec2 force, std::optional<Vec2> point) {
  Require(IsUsable(force), "a force must be finite");
  if (point) RequirePosition(*point);
  b2Body& found = Find(body);
  if (IsInListener()) {
    deferred_forces_.push_back({body, force, point, 0.0});
    return;
  }
  found.ApplyForce(ToBox2D(force), point ? ToBox2D(*point) : found.GetWorldCenter(), true);
}

void World::ApplyTorque(Body body, double torque) {
  Require(IsUsable(torque), "a torque must be finite");
  b2Body& found = Find(body);
  if (IsInListener()) {
    deferred_forces_.push_back({body, {}, std::nullopt, torque});
    return;
  }
  found.ApplyTorque(static_cast<float>(torque), true);
}

void World::ApplyDeferredForces() {
  for (const DeferredForce& deferred : deferred_forces_) {
    if (!Contains(deferred.body)) continue;
    b2Body& body = *bodies_.Get(deferred.body).body;
    const b2Vec2 point = deferred.point ? ToBox2D(*deferred.point) : body.GetWorldCenter();
    body.ApplyForce(ToBox2D(deferred.force), point, true);
    body.ApplyTorque(static_cast<float>(deferred.torque), true);
  }
  deferred_forces_.clear();
}

void World::ApplyLinearImpulse(Body body, Vec2 impulse, std::optional<Vec2> point) {
  Require(IsUsable(impulse), "an impulse must be finite");
  b2Body& found = Find(body);
  if (point) RequirePosition(*point);
  found.ApplyLinearImpulse(ToBox2D(impulse), point ? ToBox2D(*point) : found.GetWorldCenter(),
                           true);
}

void World::ApplyAngularImpulse(Body body, double impulse) {
  Require(IsUsable(impulse), "an impulse must be finite");
  Find(body).ApplyAngularImpulse(static_cast<float>(impulse), true);
}

}  // namespace flatland
