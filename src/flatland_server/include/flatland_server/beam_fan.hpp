#pragma once

/// The directions of a lidar's beams, in its own frame, with their cosines and sines.

#include <vector>

#include "flatland_server/geometry.hpp"

namespace flatland {

class BeamFan {
 public:
  /// `count` beams, the first at `angle_min` [rad], each `increment` [rad] further; a negative
  /// increment turns clockwise. Throws std::invalid_argument on a value that is not finite, on no
  /// beams, and on an increment of zero with more than one beam.
  BeamFan(double angle_min, double increment, int count);

  int size() const { return static_cast<int>(directions_.size()); }
  Vec2 direction(int beam) const { return directions_[beam]; }
  double angle_min() const { return angle_min_; }
  double increment() const { return increment_; }

  /// Calls `visit(beam)` for every beam within `half_width` of `bearing` [rad], and perhaps for its
  /// neighbours.
  template <class Visit>
  void ForEachBeamNear(double bearing, double half_width, Visit visit) const;

 private:
  double angle_min_;
  double increment_;
  std::vector<Vec2> directions_;
};

template <class Visit>
void BeamFan::ForEachBeamNear(double bearing, double half_width, Visit visit) const {
  constexpr double kTurn = 2.0 * M_PI;
  if (half_width >= M_PI || size() == 1 || std::abs(increment_) * size() > 4.0 * kTurn) {
    for (int beam = 0; beam < size(); ++beam) visit(beam);
    return;
  }
  // The same bearing recurs every turn; the fan spans the beams 0 to size() - 1.
  const double turn = kTurn / std::abs(increment_);
  const double middle = std::remainder((bearing - angle_min_) / increment_, turn);
  const double reach = half_width / std::abs(increment_) + 1.0;
  for (double center = middle - turn; center - reach < size(); center += turn) {
    const int first = static_cast<int>(std::max(0.0, std::ceil(center - reach)));
    const int last = static_cast<int>(std::min(size() - 1.0, std::floor(center + reach)));
    for (int beam = first; beam <= last; ++beam) visit(beam);
  }
}

}  // namespace flatland
