#pragma once

/// Access to what Box2D keeps from step to step and has no functions for: pending forces, the time
/// that a body has been at rest, and the impulses with which the solver starts the next step.
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
  static uint32& Flags(b2Contact& contact) { return contact.*(&ContactInternals::m_flags); }
};

struct FixtureInternals : b2Fixture {
  static b2FixtureProxy* Proxies(b2Fixture& fixture) {
    return fixture.*(&FixtureInternals::m_proxies);
  }
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

/// Defines Member(Tag()), the pointer to a private member.
template <class Tag, typename Tag::Pointer member>
struct DefineMember {
  friend constexpr typename Tag::Pointer Member(Tag) { return member; }
};

struct BodyForce {
  using Pointer = b2Vec2 b2Body::*;
  friend constexpr Pointer Member(BodyForce);
};
template struct DefineMember<BodyForce, &b2Body::m_force>;

struct BodyTorque {
  using Pointer = float b2Body::*;
  friend constexpr Pointer Member(BodyTorque);
};
template struct DefineMember<BodyTorque, &b2Body::m_torque>;

struct BodySleepTime {
  using Pointer = float b2Body::*;
  friend constexpr Pointer Member(BodySleepTime);
};
template struct DefineMember<BodySleepTime, &b2Body::m_sleepTime>;

struct BodySweep {
  using Pointer = b2Sweep b2Body::*;
  friend constexpr Pointer Member(BodySweep);
};
template struct DefineMember<BodySweep, &b2Body::m_sweep>;

struct WorldInverseStep {
  using Pointer = float b2World::*;
  friend constexpr Pointer Member(WorldInverseStep);
};
template struct DefineMember<WorldInverseStep, &b2World::m_inv_dt0>;

struct Tree {
  using Pointer = b2DynamicTree b2BroadPhase::*;
  friend constexpr Pointer Member(Tree);
};
template struct DefineMember<Tree, &b2BroadPhase::m_tree>;

struct MoveBuffer {
  using Pointer = int32* b2BroadPhase::*;
  friend constexpr Pointer Member(MoveBuffer);
};
template struct DefineMember<MoveBuffer, &b2BroadPhase::m_moveBuffer>;

struct MoveCount {
  using Pointer = int32 b2BroadPhase::*;
  friend constexpr Pointer Member(MoveCount);
};
template struct DefineMember<MoveCount, &b2BroadPhase::m_moveCount>;

inline b2Vec2& Force(b2Body& body) { return body.*Member(BodyForce()); }
inline float& Torque(b2Body& body) { return body.*Member(BodyTorque()); }
inline float& SleepTime(b2Body& body) { return body.*Member(BodySleepTime()); }
inline b2Sweep& Sweep(b2Body& body) { return body.*Member(BodySweep()); }
/// One over the length of the last step [1/s], 0 before the first.
inline float& InverseStep(b2World& world) { return world.*Member(WorldInverseStep()); }

/// Spares the next step a search for what the fixtures of a world touch that were added since the
/// last step. It must have static bodies alone.
///
/// Static fixtures have no contacts with each other. What is added later finds them: Box2D searches
/// a pair of new fixtures from the one with the higher index, which is the later one. So the
/// contacts, and their order, are the same. In a map of 5,000 walls this saves 4 ms.
inline void SkipPairsOfNewFixtures(b2World& world) {
  b2BroadPhase& phase = const_cast<b2ContactManager&>(world.GetContactManager()).m_broadPhase;
  const int32* moved = phase.*Member(MoveBuffer());
  int32& count = phase.*Member(MoveCount());
  for (int32 i = 0; i < count; ++i) {
    if (moved[i] != b2BroadPhase::e_nullProxy) (phase.*Member(Tree())).ClearMoved(moved[i]);
  }
  count = 0;
}

}  // namespace flatland::box2d
