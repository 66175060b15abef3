#include "sight/range_noise.hpp"

#include <algorithm>
#include <cmath>

#include "base/box2d_limits.hpp"
#include "base/normal_numbers.hpp"

namespace flatland {

RangeNoise::RangeNoise(uint64_t key, double std_dev, double max_range, double min_range)
    : key_(key), std_dev_(std_dev), max_range_(max_range), min_range_(min_range) {
  Require(std_dev >= 0.0 && std_dev < HUGE_VAL, "a standard deviation must be 0 or more");
  Require(max_range >= 0.0 && max_range < HUGE_VAL, "a range must be 0 or more");
  Require(min_range >= 0.0 && min_range <= max_range, "a least range must be from 0 to the range");
}

void RangeNoise::AddTo(float* ranges, int count, int64_t nanoseconds) const {
  NormalNumbers numbers(
      NormalNumbers::Mixed(key_ + NormalNumbers::Mixed(static_cast<uint64_t>(nanoseconds))));
  for (int i = 0; i < count; ++i) {
    const double noise = std_dev_ * numbers.Draw();
    if (std::isinf(ranges[i])) continue;
    ranges[i] = static_cast<float>(std::clamp(ranges[i] + noise, min_range_, max_range_));
  }
}

}  // namespace flatland
