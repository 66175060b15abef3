/// World: joints.

#include "box2d_limits.hpp"
#include "flatland_server/world.hpp"
#include "to_box2d.hpp"

namespace flatland {

World::Joint World::AddJoint(const b2JointDef& definition) {
  Require(definition.bodyA != definition.bodyB, "a joint needs two bodies");
  const AccessGuard guard(*this);
  for (b2Body* const body : {definition.bodyA, definition.bodyB}) {
    bodies_.LetMove(bodies_.HandleOf(*body));
  }
  return joints_.Add(world_->CreateJoint(&definition));
}

World::Joint World::AddRevolute(Body a, Body b, const RevoluteSettings& settings) {
  RequirePosition(settings.anchor_a);
  RequirePosition(settings.anchor_b);
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

}  // namespace flatland
