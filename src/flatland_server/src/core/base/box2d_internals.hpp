#pragma once

/// Access to what Box2D keeps from step to step and has no functions for: pending forces, the time
/// that a body has been at rest, the impulses with which the solver starts the next step, and the
/// tree of bounding boxes.
///
/// Protected members are reached by pointers to members, formed in a derived class that is never
/// instantiated; private ones by explicit instantiation of a template, in which the language does
/// not check access ([temp.spec.general]). Both are standard C++, and fail to compile if a version
/// of Box2D names or declares a member differently.

#include <box2d/box2d.h>

namespace flatland::box2d {

struct ContactInternals : b2Contact {
  static constexpr uint32 kTouching = e_touchingFlag;
  static constexpr uint32 kEnabled = e_enabledFlag;
  static constexpr uint32 kToFilter = e_filterFlag;
  static uint32& Flags(b2Contact& contact) { return contact.*(&ContactInternals::m_flags); }
};

struct FixtureInternals : b2Fixture {
  static b2FixtureProxy* Proxies(b2Fixture& fixture) {
    return fixture.*(&FixtureInternals::m_proxies);
  }
  static int32 ProxyCount(const b2Fixture& fixture) {
    return fixture.*(&FixtureInternals::m_proxyCount);
  }
  static b2Fixture*& Next(b2Fixture& fixture) { return fixture.*(&FixtureInternals::m_next); }
};

struct RevoluteInternals : b2RevoluteJoint {
  using Joint = b2RevoluteJoint;
  static b2Vec2& Impulse(Joint& joint) { return joint.*(&RevoluteInternals::m_impulse); }
  static float& MotorImpulse(Joint& joint) { return joint.*(&RevoluteInternals::m_motorImpulse); }
  static float& LowerImpulse(Joint& joint) { return joint.*(&RevoluteInternals::m_lowerImpulse); }
  static float& UpperImpulse(Joint& joint) { return joint.*(&RevoluteInternals::m_upperImpulse); }
};

struct WeldInternals : b2WeldJoint {
  static b2Vec3& Impulse(b2WeldJoint& joint) { return joint.*(&WeldInternals::m_impulse); }
};

struct FrictionInternals : b2FrictionJoint {
  using Joint = b2FrictionJoint;
  static b2Vec2& Impulse(Joint& joint) { return joint.*(&FrictionInternals::m_linearImpulse); }
  static float& AngularImpulse(Joint& joint) {
    return joint.*(&FrictionInternals::m_angularImpulse);
  }
};

/// Defines what Member(Name*) returns: the pointer to a private member.
template <class Name, auto member>
struct DefineMember {
  friend constexpr auto Member(Name*) { return member; }
};
template <class Name>
constexpr auto kMember = Member(static_cast<Name*>(nullptr));

constexpr auto Member(struct BodyForce*);
template struct DefineMember<BodyForce, &b2Body::m_force>;
constexpr auto Member(struct BodyTorque*);
template struct DefineMember<BodyTorque, &b2Body::m_torque>;
constexpr auto Member(struct BodySleepTime*);
template struct DefineMember<BodySleepTime, &b2Body::m_sleepTime>;
constexpr auto Member(struct BodySweep*);
template struct DefineMember<BodySweep, &b2Body::m_sweep>;
constexpr auto Member(struct BodyTransform*);
template struct DefineMember<BodyTransform, &b2Body::m_xf>;
constexpr auto Member(struct BodyFixtures*);
template struct DefineMember<BodyFixtures, &b2Body::m_fixtureList>;
constexpr auto Member(struct BodyContacts*);
template struct DefineMember<BodyContacts, &b2Body::m_contactList>;
constexpr auto Member(struct WorldBodyList*);
template struct DefineMember<WorldBodyList, &b2World::m_bodyList>;
constexpr auto Member(struct WorldBodyCount*);
template struct DefineMember<WorldBodyCount, &b2World::m_bodyCount>;
constexpr auto Member(struct WorldInverseStep*);
template struct DefineMember<WorldInverseStep, &b2World::m_inv_dt0>;
constexpr auto Member(struct WorldNewContacts*);
template struct DefineMember<WorldNewContacts, &b2World::m_newContacts>;
constexpr auto Member(struct WorldStepComplete*);
template struct DefineMember<WorldStepComplete, &b2World::m_stepComplete>;
constexpr auto Member(struct BroadPhaseTree*);
template struct DefineMember<BroadPhaseTree, &b2BroadPhase::m_tree>;
constexpr auto Member(struct BroadPhaseMoves*);
template struct DefineMember<BroadPhaseMoves, &b2BroadPhase::m_moveBuffer>;
constexpr auto Member(struct BroadPhaseMoveCount*);
template struct DefineMember<BroadPhaseMoveCount, &b2BroadPhase::m_moveCount>;
constexpr auto Member(struct BroadPhaseMoveCapacity*);
template struct DefineMember<BroadPhaseMoveCapacity, &b2BroadPhase::m_moveCapacity>;
constexpr auto Member(struct TreeNodes*);
template struct DefineMember<TreeNodes, &b2DynamicTree::m_nodes>;
constexpr auto Member(struct TreeNodeCapacity*);
template struct DefineMember<TreeNodeCapacity, &b2DynamicTree::m_nodeCapacity>;
constexpr auto Member(struct TreeRoot*);
template struct DefineMember<TreeRoot, &b2DynamicTree::m_root>;
constexpr auto Member(struct TreeNodeCount*);
template struct DefineMember<TreeNodeCount, &b2DynamicTree::m_nodeCount>;
constexpr auto Member(struct TreeFreeList*);
template struct DefineMember<TreeFreeList, &b2DynamicTree::m_freeList>;

inline b2Vec2& Force(b2Body& body) { return body.*kMember<BodyForce>; }
inline float& Torque(b2Body& body) { return body.*kMember<BodyTorque>; }
inline float& SleepTime(b2Body& body) { return body.*kMember<BodySleepTime>; }
inline b2Sweep& Sweep(b2Body& body) { return body.*kMember<BodySweep>; }
/// The pose of a body's origin. Computing it from the centre of mass may round differently.
inline b2Transform& Transform(b2Body& body) { return body.*kMember<BodyTransform>; }
/// The head of a body's list of fixtures. Box2D moves them in its order.
inline b2Fixture*& Fixtures(b2Body& body) { return body.*kMember<BodyFixtures>; }
/// The head of a body's list of contacts.
inline b2ContactEdge*& ContactList(b2Body& body) { return body.*kMember<BodyContacts>; }
/// The head of the list of bodies, the newest first, and their number.
inline b2Body*& BodyList(b2World& world) { return world.*kMember<WorldBodyList>; }
inline int32& BodyCount(b2World& world) { return world.*kMember<WorldBodyCount>; }
/// One over the length of the last step [1/s], 0 before the first.
inline float& InverseStep(b2World& world) { return world.*kMember<WorldInverseStep>; }
/// True if bodies or fixtures, which may have new contacts, were moved since the last step.
inline bool& NewContacts(b2World& world) { return world.*kMember<WorldNewContacts>; }
/// False: the next step only continues to solve times of impact, as after a substep.
inline bool& StepComplete(b2World& world) { return world.*kMember<WorldStepComplete>; }
inline b2ContactManager& Contacts(b2World& world) {
  return const_cast<b2ContactManager&>(world.GetContactManager());
}
inline b2DynamicTree& Tree(b2BroadPhase& broad_phase) {
  return broad_phase.*kMember<BroadPhaseTree>;
}
inline b2DynamicTree& Tree(b2World& world) { return Tree(Contacts(world).m_broadPhase); }
/// The ids of the proxies that may have new contacts, and their number.
inline int32*& Moves(b2World& world) {
  return Contacts(world).m_broadPhase.*kMember<BroadPhaseMoves>;
}
inline int32& MoveCount(b2World& world) {
  return Contacts(world).m_broadPhase.*kMember<BroadPhaseMoveCount>;
}
inline int32& MoveCapacity(b2World& world) {
  return Contacts(world).m_broadPhase.*kMember<BroadPhaseMoveCapacity>;
}
/// The nodes of a tree; the index of a leaf is the id of its proxy.
inline b2TreeNode*& Nodes(b2DynamicTree& tree) { return tree.*kMember<TreeNodes>; }
inline b2TreeNode*& Nodes(b2World& world) { return Nodes(Tree(world)); }
inline int32& Root(b2DynamicTree& tree) { return tree.*kMember<TreeRoot>; }
inline int32& Root(b2World& world) { return Root(Tree(world)); }
inline int32& NodeCapacity(b2World& world) { return Tree(world).*kMember<TreeNodeCapacity>; }
/// Number of nodes in use.
inline int32& NodeCount(b2DynamicTree& tree) { return tree.*kMember<TreeNodeCount>; }
inline int32& NodeCount(b2World& world) { return NodeCount(Tree(world)); }
/// The first of the nodes that are not in use, each of which names the next one.
inline int32& FreeList(b2World& world) { return Tree(world).*kMember<TreeFreeList>; }

/// Lets the next step skip the search for contacts of fixtures that were added since the last step:
/// those from `begin` on among the proxies that may have new contacts. They must be static, and so
/// must all bodies of the world, except those for which FindPairsAgain is called.
///
/// Static fixtures have no contacts with each other. What is added later finds them: Box2D searches
/// a pair of new fixtures from the one with the higher index, which is the later one. So the
/// contacts, and their order, are the same.
inline void SkipPairsOfNewFixtures(b2World& world, int32 begin) {
  for (int32 i = begin; i < MoveCount(world); ++i) {
    const int32 moved = Moves(world)[i];
    if (moved != b2BroadPhase::e_nullProxy) Tree(world).ClearMoved(moved);
  }
  MoveCount(world) = begin;
}

/// Lets the next step search for what a body's fixtures touch, although they have not moved.
inline void FindPairsAgain(b2Body& body) {
  b2World& world = *body.GetWorld();
  for (b2Fixture* f = body.GetFixtureList(); f != nullptr; f = f->GetNext()) {
    const b2FixtureProxy* proxies = FixtureInternals::Proxies(*f);
    for (int32 i = 0; i < FixtureInternals::ProxyCount(*f); ++i) {
      Contacts(world).m_broadPhase.TouchProxy(proxies[i].proxyId);
    }
  }
  NewContacts(world) = true;
}

}  // namespace flatland::box2d
