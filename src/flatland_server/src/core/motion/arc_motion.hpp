#pragma once

/// Moves a driven body along the exact arc of a twist in each step.

#include <box2d/box2d.h>

#include "base/geometry.hpp"
#include "motion/grip.hpp"

namespace flatland {

/// One body's motion, step by step. Box2D moves the centre of mass along a straight line in a step.
/// This chooses the velocity such that the body's origin ends on the arc of the commanded twist,
/// and after the step gives the body the velocity at the end of the arc.
class ArcMotion {
 public:
  /// Sets the body's velocity for the next step of `dt` [s]. `mean` is the mean twist of its origin
  /// over the step, in its frame [m/s, m/s, rad/s]. Bodies rigidly welded to it, and wheels hinged
  /// to it at their own centre, get the matching velocity too: otherwise they would slow it down
  /// until the solver has accelerated them. With a `grip`, the belt gets the velocity, and pulls
  /// the body.
  void Begin(b2Body& body, const Twist& mean, double dt, Grip* grip = nullptr);

  /// After the step: sets the body's velocity to the twist at the end of the arc, minus the
  /// velocity that it lost in the step, as by damping. If that is much, as at a wall, the velocity
  /// is not changed.
  void End(b2Body& body, const Twist& at_end, Grip* grip = nullptr);
  /// To be called when the body was moved.
  void Rebase() { rounding_error_ = {}; }

  /// Writes or reads what it keeps from step to step; see archive.hpp.
  template <class Archive>
  void Serialize(Archive& archive) {
    archive(rounding_error_, shown_, shown_omega_);
  }

 private:
  b2Vec2 commanded_velocity_ = b2Vec2_zero;  // of the centre of mass, in the world's frame [m/s]
  float commanded_omega_ = 0.0f;             // [rad/s]
  // Where the step should put the centre of mass, and how far rounding kept it from there. At a
  // steady speed every step is rounded alike, by 2 um at 50 m from the origin, so the error would
  // add up: each step corrects that of the one before.
  Pose target_;
  Pose rounding_error_;
  // With a grip: the velocity at the end of the arc minus the mean one of the step. It is added
  // between steps, for readers of the velocity. The next step subtracts it again: without a force,
  // the solver's velocity must not change.
  b2Vec2 shown_ = b2Vec2_zero;
  float shown_omega_ = 0.0f;
};

}  // namespace flatland
