#include "batch/goal_observer.hpp"

#include <cmath>

#include "base/box2d_limits.hpp"

namespace flatland {
namespace {

constexpr double kFarthest = 10.0, kFastest = 2.0;

/// NaN stays NaN.
template <class T>
T Clipped(T value, T limit) {
  return value > limit ? limit : value < -limit ? -limit : value;
}

}  // namespace

GoalObserver::GoalObserver(int beams, double max_range, const std::vector<double>& velocity_limits)
    : beams_(beams), max_range_(max_range) {
  Require(beams >= 0, "a number of beams must be 0 or more");
  Require(velocity_limits.size() == 3, "expected three limits of velocities");
  for (int i = 0; i < 3; ++i) {
    if (velocity_limits[i] != 0.0) parts_.push_back({i, velocity_limits[i]});
  }
}

void GoalObserver::Observe(const float* ranges, const double* pose, const double* velocity,
                           const double* goal, float* out) const {
  const auto longest = static_cast<float>(max_range_);
  for (int i = 0; i < beams_; ++i) {
    const float part = ranges[i] / longest;
    out[i] = part > 1.0f ? 1.0f : part < 0.0f ? 0.0f : part;  // nearer than the least range
  }
  out += beams_;
  const double x = goal[0] - pose[0], y = goal[1] - pose[1];
  const double cosine = std::cos(pose[2]), sine = std::sin(pose[2]);
  const double distance = std::hypot(x, y), at_goal = distance == 0.0 ? 1.0 : 0.0;
  const double safe = distance + at_goal;
  *out++ = static_cast<float>(Clipped(distance / max_range_, kFarthest));
  *out++ = Clipped(static_cast<float>((cosine * x + sine * y) / safe + at_goal), 1.0f);
  *out++ = Clipped(static_cast<float>((cosine * y - sine * x) / safe), 1.0f);
  for (const Part& part : parts_) {
    *out++ = static_cast<float>(Clipped(velocity[part.index] / part.limit, kFastest));
  }
}

}  // namespace flatland
