#include "sight/beam_fan.hpp"

#include <algorithm>
#include <numeric>
#include <stdexcept>
#include <utility>

namespace flatland {
namespace {

std::vector<Vec2> Directions(double angle_min, double increment, int count) {
  if (!IsUsable(angle_min) || !IsUsable(increment)) {
    throw std::invalid_argument("a beam's angle must be finite");
  }
  if (count > 1 && increment == 0.0) {
    throw std::invalid_argument("the angle between beams must not be zero");
  }
  std::vector<Vec2> directions;
  directions.reserve(std::max(count, 0));
  for (int beam = 0; beam < count; ++beam) {
    const double angle = angle_min + beam * increment;
    directions.push_back({std::cos(angle), std::sin(angle)});
  }
  return directions;
}

}  // namespace

BeamFan::BeamFan(double angle_min, double increment, int count)
    : BeamFan(Directions(angle_min, increment, count)) {}

BeamFan::BeamFan(std::vector<Vec2> directions) : directions_(std::move(directions)) {
  if (directions_.empty()) throw std::invalid_argument("a fan needs at least one beam");
  Sort();
}

void BeamFan::Sort() {
  std::vector<double> angles;
  for (const Vec2& direction : directions_) angles.push_back(DiamondAngle(direction));
  beams_.resize(directions_.size());
  std::iota(beams_.begin(), beams_.end(), 0);
  std::stable_sort(beams_.begin(), beams_.end(),
                   [&](int a, int b) { return angles[a] < angles[b]; });

  is_sorted_ = std::is_sorted(beams_.begin(), beams_.end());

  const size_t padded = (directions_.size() + kGroup - 1) / kGroup * kGroup + 2 * kGroup;
  xs_.assign(padded, 0.0);
  ys_.assign(padded, 0.0);
  for (size_t rank = 0; rank < beams_.size(); ++rank) {
    xs_[rank] = directions_[beams_[rank]].x;
    ys_[rank] = directions_[beams_[rank]].y;
  }

  // Two to four buckets for each beam, but at least 256 and at most 65536.
  int buckets = 256;
  while (buckets < 2 * size() && buckets < 65536) buckets *= 2;
  buckets_per_unit_ = buckets / 4.0;
  before_bucket_.assign(buckets + 2, 0);
  for (const double angle : angles) ++before_bucket_[Bucket(angle) + 1];
  std::partial_sum(before_bucket_.begin(), before_bucket_.end(), before_bucket_.begin());
}

}  // namespace flatland
