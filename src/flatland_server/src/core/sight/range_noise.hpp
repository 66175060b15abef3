#pragma once

/// Noise of a lidar's ranges.

#include <cstdint>

namespace flatland {

/// Gaussian noise that depends on a key, the time and the beam alone: neither on earlier scans nor
/// on other lidars. A scan that is made twice has the same noise.
class RangeNoise {
 public:
  /// `std_dev` and `max_range` [m] must be finite and 0 or more; throws std::invalid_argument.
  RangeNoise(uint64_t key, double std_dev, double max_range);

  uint64_t key() const { return key_; }
  /// The same noise with another key.
  RangeNoise WithKey(uint64_t key) const { return {key, std_dev_, max_range_}; }

  /// Adds the noise of a time [ns]. Ranges stay within [0, max_range]; no return stays infinite.
  void AddTo(float* ranges, int count, int64_t nanoseconds) const;

 private:
  uint64_t key_;
  double std_dev_, max_range_;
};

}  // namespace flatland
