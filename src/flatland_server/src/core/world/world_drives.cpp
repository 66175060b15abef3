/// World: drives, tweens and drifts.

#include "base/box2d_limits.hpp"
#include "base/to_box2d.hpp"
#include "world/world.hpp"

namespace flatland {
namespace {

constexpr char kNotALayer[] = "a layer cannot be moved";

}  // namespace

b2FrictionJoint* World::AddBelt(Body body, const std::optional<ActuatorSettings>& actuator) {
  if (!actuator || !actuator->force) return nullptr;
  Require(GetInertia(body) > 0.0,
          "a drive of limited force needs a dynamic body with a moment of inertia");
  BodySettings settings;
  settings.type = b2_kinematicBody;
  b2FrictionJointDef definition;
  definition.bodyB = &Find(body);
  definition.localAnchorB = definition.bodyB->GetLocalCenter();
  definition.bodyA = &Find(AddBody(settings));
  definition.collideConnected = true;
  return static_cast<b2FrictionJoint*>(joints_.Get(AddJoint(definition)));
}

World::Drive World::AddDrive(Body body, const DynamicsLimits& linear, const DynamicsLimits& angular,
                             const std::optional<ActuatorSettings>& actuator) {
  Find(body);
  Require(!bodies_.Get(body).is_layer, kNotALayer);
  BodyDrive drive(linear, angular, actuator);
  if (b2FrictionJoint* belt = AddBelt(body, actuator)) drive.actuator()->AddGrip(belt);
  const AccessGuard guard(*this);
  return mechanisms_.drives.Add({body, std::move(drive)});
}

World::Tricycle World::AddTricycle(Body body, Joint front_wheel, const TricycleSettings& settings) {
  RequireIdle();
  b2RevoluteJoint* const joint = FindWheel(body, front_wheel);
  TricycleDrive drive(settings, joint);
  if (b2FrictionJoint* belt = AddBelt(body, settings.actuator)) drive.actuator()->AddGrip(belt);
  const AccessGuard guard(*this);
  return mechanisms_.tricycles.Add({body, std::move(drive)});
}

World::Ackermann World::AddAckermann(Body body, const std::vector<Joint>& wheels,
                                     const AckermannSettings& settings) {
  RequireIdle();
  std::array<b2RevoluteJoint*, 2> joints{};
  Require(wheels.size() <= joints.size(), "a car has two steered wheels at most");
  for (size_t i = 0; i < wheels.size(); ++i) joints[i] = FindWheel(body, wheels[i]);
  Find(body);
  RequireIdle();
  Require(!bodies_.Get(body).is_layer, kNotALayer);
  AckermannDrive drive(settings, joints);
  if (b2FrictionJoint* belt = AddBelt(body, settings.actuator)) drive.actuator()->AddGrip(belt);
  const AccessGuard guard(*this);
  return mechanisms_.cars.Add({body, std::move(drive)});
}

b2RevoluteJoint* World::FindWheel(Body body, Joint wheel) const {
  const b2Body& base = Find(body);
  b2Joint* const joint = joints_.Get(wheel);
  Require(joint->GetType() == e_revoluteJoint &&
              (joint->GetBodyA() == &base || joint->GetBodyB() == &base),
          "a steered wheel's joint must be a revolute joint of the driven body");
  return static_cast<b2RevoluteJoint*>(joint);
}

World::Tween World::AddTween(Body body, const TweenSettings& settings) {
  const Pose start = GetPose(body);
  const AccessGuard guard(*this);
  Require(!bodies_.Get(body).is_layer, kNotALayer);
  bodies_.AllowMotion(body);
  return mechanisms_.tweens.Add({body, BodyTween(settings, start)});
}

World::Drift World::AddDrift(Body body, const DriftVariances& variances, double period,
                             uint64_t key) {
  const Pose start = GetPose(body);
  const AccessGuard guard(*this);
  const Actuator* wheels = nullptr;
  mechanisms_.ForEachActuator([&](Body driven, Actuator& actuator) {
    if (driven.index == body.index && actuator.may_slip()) wheels = &actuator;
  });
  return mechanisms_.drifts.Add({body, BodyDrift(variances, period, key, start, wheels)});
}

Pose World::GetEstimate(Drift drift) const {
  const auto& [body, mechanism] = mechanisms_.drifts.Get(drift);
  return mechanism.Estimate(GetPose(body));
}

}  // namespace flatland
