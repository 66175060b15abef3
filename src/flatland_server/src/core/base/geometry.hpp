#pragma once

/// Points, poses, velocities and rotations in the plane. In double precision, unlike Box2D: maps
/// are tens of metres wide and lidars measure millimetres.

#include <cmath>

namespace flatland {

/// A point or vector in the plane [m].
struct Vec2 {
  double x = 0.0;
  double y = 0.0;
};

/// Position [m] and heading [rad], counter-clockwise from +x (REP 103).
struct Pose {
  double x = 0.0;
  double y = 0.0;
  double yaw = 0.0;
};

/// Velocity along x and y [m/s] and about z [rad/s].
struct Twist {
  double vx = 0.0;
  double vy = 0.0;
  double omega = 0.0;
};

/// A wall: the straight line between two points [m].
struct Segment {
  Vec2 a;
  Vec2 b;
};

inline Vec2 operator+(Vec2 a, Vec2 b) { return {a.x + b.x, a.y + b.y}; }
inline Vec2 operator-(Vec2 a, Vec2 b) { return {a.x - b.x, a.y - b.y}; }
inline Vec2 operator*(double factor, Vec2 v) { return {factor * v.x, factor * v.y}; }
inline double Dot(Vec2 a, Vec2 b) { return a.x * b.x + a.y * b.y; }
inline double Cross(Vec2 a, Vec2 b) { return a.x * b.y - a.y * b.x; }
inline double LengthOf(Vec2 v) { return std::sqrt(Dot(v, v)); }

/// True if Box2D can compute with a number: finite, and small enough that its square is finite in
/// single precision too.
inline bool IsUsable(double value) { return std::abs(value) <= 1e9; }
inline bool IsUsable(Vec2 v) { return IsUsable(v.x) && IsUsable(v.y); }
inline bool IsUsable(const Pose& p) { return IsUsable(Vec2{p.x, p.y}) && IsUsable(p.yaw); }
inline bool IsUsable(const Twist& t) { return IsUsable(Vec2{t.vx, t.vy}) && IsUsable(t.omega); }

/// A rotation, stored as its cosine and sine, which are computed once for many vectors.
struct Rotation {
  explicit Rotation(double yaw) : cos(std::cos(yaw)), sin(std::sin(yaw)) {}

  Vec2 Apply(Vec2 v) const { return {cos * v.x - sin * v.y, sin * v.x + cos * v.y}; }
  Vec2 ApplyInverse(Vec2 v) const { return {cos * v.x + sin * v.y, cos * v.y - sin * v.x}; }

  double cos;
  double sin;
};

/// Transforms `inner`, which is given in the frame of `outer`, to the parent frame of `outer`.
inline Pose Compose(const Pose& outer, const Pose& inner) {
  const double cos = std::cos(outer.yaw), sin = std::sin(outer.yaw);
  return {outer.x + cos * inner.x - sin * inner.y, outer.y + sin * inner.x + cos * inner.y,
          outer.yaw + inner.yaw};
}
/// The inverse transform: the pose of the parent frame in the frame of `pose`.
inline Pose Inverse(const Pose& pose) {
  const double cos = std::cos(pose.yaw), sin = std::sin(pose.yaw);
  return {-cos * pose.x - sin * pose.y, sin * pose.x - cos * pose.y, -pose.yaw};
}
/// The angle wrapped to [-pi, pi]. std::remainder is slow, and most angles do not need it.
inline double WrappedAngle(double angle) {
  return std::abs(angle) <= M_PI ? angle : std::remainder(angle, 2.0 * M_PI);
}
/// The pose with its yaw within [-pi, pi].
inline Pose Wrapped(const Pose& pose) { return {pose.x, pose.y, WrappedAngle(pose.yaw)}; }
inline bool operator==(const Pose& a, const Pose& b) {
  return a.x == b.x && a.y == b.y && a.yaw == b.yaw;
}

}  // namespace flatland
