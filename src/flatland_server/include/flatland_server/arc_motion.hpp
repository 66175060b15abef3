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
  /// of the twist of its origin, in its frame. Bodies that are welded to it, unless by a spring,
  /// and wheels that turn about their own centre on it, move along: they would slow it down until
  /// the solver has brought them up to its speed.
  void Begin(b2Body& body, const Twist& mean, double dt);

  /// After the step: gives the body the twist that it has at the end, less what something took from
  /// it meanwhile. Not if something stopped it or turned it aside: then it has what the solver
  /// left.
  void End(b2Body& body, const Twist& at_end);

 private:
  b2Vec2 told_velocity_ = b2Vec2_zero;
  float told_omega_ = 0.0f;
  // Where the centre of mass is due, and by what rounding kept it from there. In single precision
  // every step of a steady drive is rounded the same way, 50 m from the origin by 2 um: what one
  // step loses, the next one makes good.
  Pose due_;
  Pose behind_;
  std::vector<b2Body*> group_;  // kept only to save its memory from step to step
};

}  // namespace flatland
