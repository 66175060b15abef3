#pragma once

/// Noise of a lidar's ranges.

#include <cstdint>

namespace flatland {

/// Gaussian noise that depends on a key, the time and the beam alone: neither on earlier scans nor
/// on other lidars. A scan that is made twice has the same noise.
class RangeNoise {
 public:
  /// `std_dev`, `max_range` and `min_range` [m] must be finite and 0 or more, and the last one no
  /// greater than the one before; throws std::invalid_argument.
  RangeNoise(uint64_t key, double std_dev, double max_range, double min_range = 0.0);

  uint64_t key() const { return key_; }
  double std_dev() const { return std_dev_; }
  double max_range() const { return max_range_; }
  double min_range() const { return min_range_; }
  /// The same noise with another key.
  RangeNoise WithKey(uint64_t key) const { return {key, std_dev_, max_range_, min_range_}; }

  /// Adds the noise of a time [ns]. Ranges stay within [min_range, max_range]; infinite ones stay.
  void AddTo(float* ranges, int count, int64_t nanoseconds) const;

 private:
  uint64_t key_;
  double std_dev_, max_range_, min_range_;
};

}  // namespace flatland
