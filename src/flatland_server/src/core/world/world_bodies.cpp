/// World: bodies.

#include "base/box2d_limits.hpp"
#include "base/to_box2d.hpp"
#include "world/layers.hpp"
#include "world/world.hpp"

namespace flatland {
namespace {

constexpr char kNotDynamic[] = "only a dynamic body has a mass";

}  // namespace

b2Body& World::Find(Body body) const {
  RequireAccess();
  return *bodies_.Get(body).body;
}

World::Body World::AddLayer(std::vector<Segment> walls, LayerBits layers,
                            const std::function<void(std::size_t added)>& progress) {
  RequireWalls(walls);
  const AccessGuard guard(*this);
  return layers_->Add(*world_, std::move(walls), layers, progress);
}

int World::body_count() const {
  return world_->GetBodyCount() - layers_->held_body_count() - grip_count();
}

int World::held_wall_count() const { return layers_->held_wall_count(); }

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
  record.ResetMass();
  record.may_move = settings.type != b2_staticBody || IsWound(*record.body);
  return bodies_.Add(std::move(record));
}

void World::RemoveBody(Body body) {
  Find(body);
  std::vector<Body> belts;
  ForEachGrip([&](Body driven, const Grip& grip) {
    if (driven.index == body.index) belts.push_back(bodies_.HandleOf(*grip.belt()));
  });
  for (const Body& belt : belts) RemoveBody(belt);
  const AccessGuard guard(*this);
  BodyRecord& record = bodies_.Get(body);
  Require(!record.is_layer, "a layer cannot be removed");
  mechanisms_.ForEachMap([&](auto& map) { map.RemoveFrom(body); });
  lidars_.RemoveFrom(body);
  crowds_.ForEach([body](auto, Crowd& crowd) { crowd.RemoveBody(body); });
  bodies_.ChangeStructure();
  world_->DestroyBody(record.body);  // ends its contacts, and calls the contact listener for them
  layers_->ReleaseWallsNear(*world_, record);
  bodies_.Remove(body);
  contacts_.RunDeferred();
}

Pose World::GetPose(Body body) const { return PoseOf(Find(body)); }

Pose World::GetPoseIn(Body reference, Body body) const {
  const Pose from = GetPose(reference);
  const Pose to = GetPose(body);
  const double yaw = WrappedAngle(from.yaw);
  const Vec2 position = Rotation(yaw).ApplyInverse(Vec2{to.x, to.y} - Vec2{from.x, from.y});
  return {position.x, position.y, WrappedAngle(to.yaw) - yaw};
}

void World::SetPose(Body body, const Pose& pose) {
  RequirePosition({pose.x, pose.y});
  Require(IsUsable(pose.yaw), "a heading must be finite");
  b2Body& found = Find(body);
  const Twist velocity = GetVelocity(body);
  const AccessGuard guard(*this);
  Require(!bodies_.Get(body).is_layer, "a layer cannot be moved");
  bodies_.AllowMotion(body);
  bodies_.ChangePoses();
  WakeBodiesNear(found);
  Place(found, pose);
  WakeBodiesNear(found);
  SetOriginVelocity(found, velocity);
  found.SetAwake(true);
  mechanisms_.tweens.ForEachOn(body, [&](auto, BodyTween& tween) { tween.Rebase(PoseOf(found)); });
  mechanisms_.ForEachDriveOn(body, [](auto& drive) { drive.Rebase(); });
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
  mechanisms_.ForEachDriveOn(body, [](auto& drive) { drive.Reset(); });
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

Vec2 World::GetLocalCenter(Body body) const { return FromBox2D(Find(body).GetLocalCenter()); }

void World::SetMass(Body body, double mass, std::optional<double> inertia,
                    std::optional<Vec2> center) {
  const b2Body& found = Find(body);
  Require(found.GetType() == b2_dynamicBody, kNotDynamic);
  Require(mass >= kMinMass && mass <= kMaxMass, "a mass must be 1e-12 to 1e12 kg");
  if (center) RequirePosition(*center);
  const double about_center = inertia.value_or(GetInertia(body) / found.GetMass() * mass);
  b2MassData data;
  data.mass = static_cast<float>(mass);
  data.center = center ? ToBox2D(*center) : found.GetLocalCenter();
  data.I = static_cast<float>(about_center + mass * data.center.LengthSquared());
  if (inertia || data.I != 0.0f) {  // a body without density has no inertia
    Require(about_center >= kMinInertia && about_center <= kMaxInertia,
            "a body needs a moment of inertia of 1e-24 to 1e24 kg m^2");
    RequireInertia(data, "an inertia is too small for the mass, so far from the body's origin");
  }
  SetMassData(body, data);
}

void World::ResetMass(Body body) {
  Require(Find(body).GetType() == b2_dynamicBody, kNotDynamic);
  SetMassData(body, bodies_.Get(body).mass.ToBox2D());
}

void World::SetMassData(Body body, const b2MassData& data) {
  ApplyOrDefer(body, [this, body, data](b2Body&) {
    BodyRecord& record = bodies_.Get(body);
    record.SetMass(data);
    record.nearby.is_current = false;  // walls are looked up around the centre of mass
  });
}

void World::ApplyForce(Body body, Vec2 force, std::optional<Vec2> point) {
  Require(IsUsable(force), "a force must be finite");
  if (point) RequirePosition(*point);
  ApplyOrDefer(body, [=](b2Body& found) {
    found.ApplyForce(ToBox2D(force), point ? ToBox2D(*point) : found.GetWorldCenter(), true);
  });
}

void World::ApplyTorque(Body body, double torque) {
  Require(IsUsable(torque), "a torque must be finite");
  ApplyOrDefer(body, [=](b2Body& found) { found.ApplyTorque(static_cast<float>(torque), true); });
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
