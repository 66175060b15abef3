#include "world/box2d_copies.hpp"

#include "base/box2d_internals.hpp"

namespace flatland::box2d {

b2BodyDef DefinitionOf(b2Body& body) {
  b2BodyDef definition;
  definition.type = body.GetType();
  definition.position = body.GetPosition();
  definition.angle = body.GetAngle();
  definition.linearDamping = body.GetLinearDamping();
  definition.angularDamping = body.GetAngularDamping();
  definition.userData = body.GetUserData();
  return definition;
}

b2FixtureDef DefinitionOf(b2Fixture& fixture) {
  b2FixtureDef definition;
  definition.shape = fixture.GetShape();
  definition.userData = fixture.GetUserData();
  definition.density = fixture.GetDensity();
  definition.friction = fixture.GetFriction();
  definition.restitution = fixture.GetRestitution();
  definition.isSensor = fixture.IsSensor();
  definition.filter = fixture.GetFilterData();
  return definition;
}

namespace {

/// The definition of a joint between bodies, with what all joints have.
template <class Definition, class Joint>
Definition Define(b2Joint& old, const Joint& joint, b2Body* a, b2Body* b) {
  Definition definition;
  definition.bodyA = a;
  definition.bodyB = b;
  definition.collideConnected = old.GetCollideConnected();
  definition.localAnchorA = joint.GetLocalAnchorA();
  definition.localAnchorB = joint.GetLocalAnchorB();
  return definition;
}

}  // namespace

b2Joint* CopyJoint(b2World& world, b2Joint& old, b2Body* a, b2Body* b) {
  if (old.GetType() == e_weldJoint) {
    const auto& weld = static_cast<b2WeldJoint&>(old);
    auto definition = Define<b2WeldJointDef>(old, weld, a, b);
    definition.referenceAngle = weld.GetReferenceAngle();
    definition.stiffness = weld.GetStiffness();
    definition.damping = weld.GetDamping();
    return world.CreateJoint(&definition);
  }
  if (old.GetType() == e_frictionJoint) {
    const auto& friction = static_cast<b2FrictionJoint&>(old);
    auto definition = Define<b2FrictionJointDef>(old, friction, a, b);
    definition.maxForce = friction.GetMaxForce();
    definition.maxTorque = friction.GetMaxTorque();
    return world.CreateJoint(&definition);
  }
  const auto& hinge = static_cast<b2RevoluteJoint&>(old);
  auto definition = Define<b2RevoluteJointDef>(old, hinge, a, b);
  definition.referenceAngle = hinge.GetReferenceAngle();
  definition.enableLimit = hinge.IsLimitEnabled();
  definition.lowerAngle = hinge.GetLowerLimit();
  definition.upperAngle = hinge.GetUpperLimit();
  definition.enableMotor = hinge.IsMotorEnabled();
  definition.motorSpeed = hinge.GetMotorSpeed();
  definition.maxMotorTorque = hinge.GetMaxMotorTorque();
  return world.CreateJoint(&definition);
}

b2Contact* MakeContact(b2World& world, b2Fixture& a, b2Fixture& b) {
  b2ContactManager& manager = Contacts(world);
  const int32 before = manager.m_contactCount;
  manager.AddPair(FixtureInternals::Proxies(a), FixtureInternals::Proxies(b));
  return manager.m_contactCount == before ? nullptr : manager.m_contactList;
}

}  // namespace flatland::box2d
