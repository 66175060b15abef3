#pragma once

/// Conversion between the core's double precision and Box2D's single precision, and bodies as Box2D
/// has them.

#include <box2d/box2d.h>

#include <cmath>

#include "base/geometry.hpp"

namespace flatland {

inline b2Vec2 ToBox2D(Vec2 v) { return {static_cast<float>(v.x), static_cast<float>(v.y)}; }
inline Vec2 FromBox2D(b2Vec2 v) { return {v.x, v.y}; }

/// Pose of a body's origin in the world. The yaw is not wrapped to [-pi, pi].
inline Pose PoseOf(const b2Body& body) {
  const Vec2 position = FromBox2D(body.GetPosition());
  return {position.x, position.y, body.GetAngle()};
}

constexpr float kFullRotation = 2.0f * b2_pi;

/// True if a body's angle is more than a whole rotation.
inline bool IsWound(const b2Body& body) { return std::abs(body.GetAngle()) > kFullRotation; }

/// Moves a body; adds the multiple of 2 pi that keeps its angle nearest to the present one.
void Place(b2Body& body, const Pose& pose);
/// Adds whole rotations to a body's angle, and to those of all bodies that a joint compares with
/// it. A hinge without limits compares nothing.
void AddRotations(b2Body& body, float count);
/// Wakes the bodies that a static body may touch; Box2D does not do so.
void WakeBodiesNear(const b2Body& body);

/// Sets the velocity of a body's origin, in the world's frame. Box2D stores the velocity of the
/// centre of mass. Most bodies have it at their origin; then the sum below equals the velocity,
/// except perhaps for the sign of a zero.
inline void SetOriginVelocity(b2Body& body, const Twist& velocity) {
  Vec2 linear{velocity.vx, velocity.vy};
  const b2Vec2 center = body.GetLocalCenter();
  const auto is_negative_zero = [](double v) { return v == 0.0 && std::signbit(v); };
  if (center != b2Vec2_zero || is_negative_zero(linear.x) || is_negative_zero(linear.y)) {
    const Vec2 arm = Rotation(body.GetAngle()).Apply(FromBox2D(center));
    linear = linear + velocity.omega * Vec2{-arm.y, arm.x};
  }
  body.SetLinearVelocity(ToBox2D(linear));
  body.SetAngularVelocity(static_cast<float>(velocity.omega));
}

}  // namespace flatland
