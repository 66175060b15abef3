#pragma once

/// Reference motions: velocities in closed form, and the poses to which they lead.

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "base/geometry.hpp"

namespace flatland {

/// A piecewise linear function of time, given by its corner points, and constant after the last.
/// Two points at the same time are a jump.
class Course {
 public:
  struct Point {
    double time;
    double value;
  };

  Course(std::vector<Point> points) : points_(std::move(points)) {}

  double At(double time) const {
    for (size_t i = 0; i + 1 < points_.size(); ++i) {
      if (time < points_[i + 1].time) return Between(points_[i], points_[i + 1], time);
    }
    return points_.back().value;
  }

  /// True if it is continuous there.
  bool IsSteadyAt(double time) const {
    constexpr double kLittle = 1e-9;
    return std::abs(At(time + kLittle) - At(time - kLittle)) < 1e3 * kLittle;
  }

  /// From the first point to `time`, exactly: a sum of trapezoids.
  double Integral(double time) const {
    double sum = 0.0;
    for (size_t i = 0; i + 1 < points_.size() && points_[i].time < time; ++i) {
      const Point from = points_[i];
      const double until = std::min(time, points_[i + 1].time);
      const double value =
          until < points_[i + 1].time ? Between(from, points_[i + 1], until) : points_[i + 1].value;
      sum += 0.5 * (from.value + value) * (until - from.time);
    }
    return sum + points_.back().value * std::max(0.0, time - points_.back().time);
  }

  double Mean(double from, double to) const {
    return (Integral(to) - Integral(from)) / (to - from);
  }
  double end() const { return points_.back().time; }

 private:
  static double Between(Point a, Point b, double time) {
    return a.value + (b.value - a.value) * (time - a.time) / (b.time - a.time);
  }

  std::vector<Point> points_;
};

/// The pose of a frame that moves from `pose` at the twist `twist_at(time)`, in its own frame, from
/// one time to another [s]. By the midpoint rule, with steps of 0.1 ms.
template <class TwistAt>
Pose Travel(Pose pose, double from, double to, TwistAt twist_at) {
  constexpr double kLongest = 1e-4;
  const int steps = std::max(1, static_cast<int>(std::ceil((to - from) / kLongest - 1e-6)));
  const double dt = (to - from) / steps;
  for (int step = 0; step < steps; ++step) {
    const Twist twist = twist_at(from + (step + 0.5) * dt);
    const Vec2 moves = Rotation(pose.yaw + 0.5 * twist.omega * dt).Apply({twist.vx, twist.vy});
    pose = {pose.x + moves.x * dt, pose.y + moves.y * dt, pose.yaw + twist.omega * dt};
  }
  return pose;
}

}  // namespace flatland
