#pragma once

/// The force between a drive's wheels and the floor, which is limited.

#include <box2d/box2d.h>

#include "base/geometry.hpp"

namespace flatland {

/// Limits of the force and the torque that a drive pushes its body with. 0 is no limit of its own.
struct ForceLimits {
  double max_force = 0.0;   ///< of the motors [N]
  double max_torque = 0.0;  ///< about the centre of mass [N m]
  double friction = 0.0;    ///< coefficient of the tyres: beyond it, wheels slip

  explicit operator bool() const { return max_force > 0.0 || max_torque > 0.0 || friction > 0.0; }
  /// Calls `visit` with each number.
  template <class Visit>
  void ForEachSetting(Visit visit) {
    visit(max_force, max_torque, friction);
  }
};

/// Moves a body by a belt under it. The belt is a body without fixtures that moves at the velocity
/// of the wheels. A friction joint pulls the driven body to that velocity with a limited force.
/// Box2D solves the joint together with contacts and other joints. A body that has none of them
/// gets the same impulse directly, at a quarter of the cost.
///
/// The limits are the lower ones of the motors and of friction, mu m g, with the mass m of the body
/// and what is rigidly on it. If only the force is limited, the limit of the torque is that force
/// at the radius of gyration, sqrt(I / m); and vice versa.
class Grip {
 public:
  Grip() = default;
  Grip(const ForceLimits& limits, b2FrictionJoint* joint) : limits_(limits), joint_(joint) {}

  explicit operator bool() const { return joint_ != nullptr; }
  b2Body* belt() const { return joint_->GetBodyA(); }
  /// Must be called when `other` replaces a joint, or when a joint is destroyed (`other` is null).
  void Replace(const b2Joint* joint, b2Joint* other) {
    if (joint == joint_) joint_ = static_cast<b2FrictionJoint*>(other);
  }
  b2FrictionJoint* joint() const { return joint_; }

  /// Before a step of `dt` [s]: pulls the body towards this velocity of its centre of mass [m/s]
  /// and yaw rate [rad/s], with the limits for this mass on its wheels [kg].
  void Begin(b2Body& body, double mass_on_wheels, b2Vec2 velocity, float omega, double dt);
  /// After a step: takes the belt back to where it was.
  void End();
  /// True if the wheels spin or slide when the force, or the torque, is not enough. Otherwise the
  /// motors stall, and the wheels roll with the body.
  bool slips() const { return slips_; }
  bool spins() const { return spins_; }

  /// Writes or reads what it keeps from step to step; see archive.hpp.
  template <class Archive>
  void Serialize(Archive& archive) {
    archive(slips_, spins_);
  }
  template <class Visit>
  void ForEachPart(Visit visit) {
    visit(slips_, spins_);
  }
  template <class Visit>
  void ForEachSetting(Visit visit) {
    limits_.ForEachSetting(visit);
  }

 private:
  ForceLimits limits_;
  b2FrictionJoint* joint_ = nullptr;
  bool slips_ = false;
  bool spins_ = false;
};

}  // namespace flatland
