#pragma once

/// Moves a body through a step by the velocity of its origin, exactly.

#include <box2d/box2d.h>

#include <vector>

#include "flatland_server/geometry.hpp"

namespace flatland {

/// A step of a driven body. Box2D moves the centre of mass along a straight line in a step; here
/// the body's origin ends on the arc of a twist, and the body has the velocity of that end.
class ArcMotion {
 public:
  /// Sets the body's velocity for the coming step of `dt` seconds. `mean` is the mean over the step
  /// of the twist of its origin, in its frame. Bodies that are welded to it, and wheels that turn
  /// about their own centre on it, move along: they would slow it down until the solver has brought
  /// them up to its speed.
  void Begin(b2Body& body, const Twist& mean, double dt);

  /// After the step: gives the body the twist that it has at the end. Not if something stopped it
  /// or turned it aside.
  void End(b2Body& body, const Twist& at_end) const;

 private:
  b2Vec2 told_velocity_ = b2Vec2_zero;
  float told_omega_ = 0.0f;
  std::vector<b2Body*> group_;  // kept only to save its memory from step to step
};

}  // namespace flatland
