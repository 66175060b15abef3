/// World: joints.

#include "base/box2d_internals.hpp"
#include "base/box2d_limits.hpp"
#include "base/to_box2d.hpp"
#include "world/world.hpp"

namespace flatland {
namespace {

void RequireLimits(const std::optional<JointLimits>& limits) {
  if (!limits) return;
  const auto [lower, upper] = *limits;
  Require(IsUsable(lower) && IsUsable(upper) && lower <= upper,
          "a joint's limits must be finite, the lower one first");
}

}  // namespace

World::Joint World::AddJoint(const b2JointDef& definition) {
  Require(definition.bodyA != definition.bodyB, "a joint needs two bodies");
  const AccessGuard guard(*this);
  for (b2Body* const body : {definition.bodyA, definition.bodyB}) {
    bodies_.AllowMotion(bodies_.HandleOf(*body));
  }
  return joints_.Add(world_->CreateJoint(&definition));
}

World::Joint World::AddRevolute(Body a, Body b, const RevoluteSettings& settings) {
  RequirePosition(settings.anchor_a);
  RequirePosition(settings.anchor_b);
  RequireLimits(settings.limits);
  b2RevoluteJointDef definition;
  definition.bodyA = &Find(a);
  definition.bodyB = &Find(b);
  definition.localAnchorA = ToBox2D(settings.anchor_a);
  definition.localAnchorB = ToBox2D(settings.anchor_b);
  definition.collideConnected = settings.collide_connected;
  if (settings.limits) {
    definition.enableLimit = true;
    definition.lowerAngle = static_cast<float>(settings.limits->first);
    definition.upperAngle = static_cast<float>(settings.limits->second);
  }
  return AddJoint(definition);
}

World::Joint World::AddWeld(Body a, Body b, const WeldSettings& settings) {
  RequirePosition(settings.anchor_a);
  RequirePosition(settings.anchor_b);
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

/// Called by Box2D for each joint of a body that is being removed.
void World::SayGoodbye(b2Joint* joint) {
  mechanisms_.ReplaceJoint(joint, nullptr);
  joints_.ForEach([&](Joint handle, b2Joint* candidate) {
    if (candidate == joint) joints_.Remove(handle);
  });
}

double World::GetJointAngle(Joint joint) const {
  RequireAccess();
  b2Joint* found = joints_.Get(joint);
  double angle = found->GetBodyB()->GetAngle() - found->GetBodyA()->GetAngle();
  if (found->GetType() == e_weldJoint) {
    angle -= static_cast<b2WeldJoint*>(found)->GetReferenceAngle();
  }
  return WrappedAngle(angle);
}

double World::GetJointSpeed(Joint joint) const {
  RequireAccess();
  b2Joint* found = joints_.Get(joint);
  return found->GetBodyB()->GetAngularVelocity() - found->GetBodyA()->GetAngularVelocity();
}

b2RevoluteJoint& World::FindHinge(Joint joint) const {
  RequireAccess();
  b2Joint* const found = joints_.Get(joint);
  Require(found->GetType() == e_revoluteJoint, "a weld has no limits and no motor");
  return static_cast<b2RevoluteJoint&>(*found);
}

std::optional<JointLimits> World::GetLimits(Joint joint) const {
  const b2RevoluteJoint& hinge = FindHinge(joint);
  if (!hinge.IsLimitEnabled()) return std::nullopt;
  return JointLimits(hinge.GetLowerLimit(), hinge.GetUpperLimit());
}

void World::SetLimits(Joint joint, const std::optional<JointLimits>& limits) {
  RequireLimits(limits);
  ApplyOrDefer(joint, [this, limits](b2RevoluteJoint& hinge) {
    const auto [lower, upper] = limits.value_or(JointLimits());
    if (limits && !hinge.IsLimitEnabled()) {
      const double raw = hinge.GetJointAngle(), middle = 0.5 * (lower + upper);
      double angle = WrappedAngle(raw);
      if (angle < lower || angle > upper) angle = middle + WrappedAngle(raw - middle);
      const auto rotations = static_cast<float>(std::round((raw - angle) / (2.0 * M_PI)));
      if (rotations != 0.0f) {
        AddRotations(*hinge.GetBodyB(), -rotations);
        bodies_.ChangePoses();
      }
    }
    hinge.EnableLimit(limits.has_value());
    hinge.SetLimits(static_cast<float>(lower), static_cast<float>(upper));
  });
}

std::optional<JointMotor> World::GetMotor(Joint joint) const {
  const b2RevoluteJoint& hinge = FindHinge(joint);
  if (!hinge.IsMotorEnabled()) return std::nullopt;
  return JointMotor{hinge.GetMotorSpeed(), hinge.GetMaxMotorTorque()};
}

void World::SetMotor(Joint joint, const std::optional<JointMotor>& motor) {
  const JointMotor values = motor.value_or(JointMotor());
  Require(IsUsable(values.speed), "a motor's speed must be finite");
  RequireNotNegative(values.max_torque, "a motor's torque must be finite and not negative");
  ApplyOrDefer(joint, [values, is_on = motor.has_value()](b2RevoluteJoint& hinge) {
    hinge.EnableMotor(is_on);
    hinge.SetMotorSpeed(static_cast<float>(values.speed));
    hinge.SetMaxMotorTorque(static_cast<float>(values.max_torque));
  });
}

double World::GetMotorTorque(Joint joint) const {
  return FindHinge(joint).GetMotorTorque(box2d::InverseStep(*world_));
}

}  // namespace flatland
