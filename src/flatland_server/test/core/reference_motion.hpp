#pragma once

/// What motions are checked against: velocities that are known in closed form, and where they lead.

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "flatland_server/geometry.hpp"

namespace flatland {

/// A value that goes along straight lines from one given moment to the next, and stays as it is
/// after the last. Two moments at the same time are a jump.
class Course {
 public:
  struct Moment {
    double time;
    double value;
  };

  Course(std::vector<Moment> moments) : moments_(std::move(moments)) {}

  double At(double time) const {
    for (size_t i = 0; i + 1 < moments_.size(); ++i) {
      if (time < moments_[i + 1].time) return Between(moments_[i], moments_[i + 1], time);
    }
    return moments_.back().value;
  }

  /// Whether it does not jump there.
  bool IsSteadyAt(double time) const {
    constexpr double kInstant = 1e-9;
    return std::abs(At(time + kInstant) - At(time - kInstant)) < 1e3 * kInstant;
  }

  /// From the first moment to `time`, exactly: a sum of trapezoids.
  double Integral(double time) const {
    double sum = 0.0;
    for (size_t i = 0; i + 1 < moments_.size() && moments_[i].time < time; ++i) {
      const Moment from = moments_[i];
      const double until = std::min(time, moments_[i + 1].time);
      const double value = until < moments_[i + 1].time ? Between(from, moments_[i + 1], until)
                                                        : moments_[i + 1].value;
      sum += 0.5 * (from.value + value) * (until - from.time);
    }
    return sum + moments_.back().value * std::max(0.0, time - moments_.back().time);
  }

  double Mean(double from, double to) const {
    return (Integral(to) - Integral(from)) / (to - from);
  }
  double end() const { return moments_.back().time; }

 private:
  static double Between(Moment a, Moment b, double time) {
    return a.value + (b.value - a.value) * (time - a.time) / (b.time - a.time);
  }

  std::vector<Moment> moments_;
};

/// Where a frame gets to that moves from `pose` with the twist `twist_at(time)` of its own, from
/// one time to another. The midpoint rule, in steps that are short beside anything of interest.
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
