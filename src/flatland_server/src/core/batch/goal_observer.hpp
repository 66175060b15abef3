#pragma once

/// Observations of robots that drive to goals.

#include <vector>

namespace flatland {

/// Makes the input of a network out of what a robot measures: its scan, the goal relative to it,
/// and its velocity.
class GoalObserver {
 public:
  /// `max_range` [m] of the lidar; `velocity_limits` by which the velocities forwards, to the left
  /// and turning are divided: 0 leaves the part out.
  GoalObserver(int beams, double max_range, const std::vector<double>& velocity_limits);

  int beams() const { return beams_; }
  /// Length of an observation.
  int size() const { return beams_ + 3 + static_cast<int>(parts_.size()); }

  /// Writes an observation.
  ///
  /// @param ranges  of the beams [m]; infinite for no return
  /// @param pose  x, y [m] and yaw [rad]
  /// @param velocity  forwards, to the left, turning
  /// @param goal  x, y [m]
  /// @param out  range / maximum, 1 at most; the goal's distance / maximum, 10 at most; cosine and
  ///     sine of its bearing, 1 and 0 at the goal; each velocity / its limit, within [-2, 2]
  void Observe(const float* ranges, const double* pose, const double* velocity, const double* goal,
               float* out) const;

 private:
  struct Part {
    int index;
    double limit;
  };
  int beams_;
  double max_range_;
  std::vector<Part> parts_;  // of the velocity
};

}  // namespace flatland
