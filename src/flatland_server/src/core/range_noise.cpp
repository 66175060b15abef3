#include "flatland_server/range_noise.hpp"

#include <algorithm>
#include <cmath>

#include "box2d_limits.hpp"

namespace flatland {
namespace {

uint64_t Mixed(uint64_t z) {
  z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
  z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
  return z ^ (z >> 31);
}

class SplitMix64 {
 public:
  explicit SplitMix64(uint64_t state) : state_(state) {}
  /// Uniform, between 0 and 1, neither of them included.
  double Draw() {
    state_ += 0x9e3779b97f4a7c15u;
    return (static_cast<double>(Mixed(state_) >> 11) + 0.5) * 0x1p-53;
  }

 private:
  uint64_t state_;
};

/// A quotient of polynomials; the first coefficient is that of the constant.
template <int n, int m>
double Quotient(const double (&above)[n], const double (&below)[m], double x) {
  double numerator = above[n - 1], denominator = below[m - 1];
  for (int i = n - 2; i >= 0; --i) numerator = numerator * x + above[i];
  for (int i = m - 2; i >= 0; --i) denominator = denominator * x + below[i];
  return numerator / denominator;
}

constexpr double kA[] = {3.3871327179, 50.434271938, 159.29113202, 59.109374720};
constexpr double kB[] = {1.0, 17.895169469, 78.757757664, 67.187563600};
constexpr double kC[] = {1.4234372777, 2.7568153900, 1.3067284816, 0.17023821103};
constexpr double kD[] = {1.0, 0.73700164250, 0.12021132975};
constexpr double kE[] = {6.6579051150, 3.0812263860, 0.42868294337, 0.017337203997};
constexpr double kF[] = {1.0, 0.24197894225, 0.012258202635};

/// The number below which a standard normal one is with this probability.
double NormalQuantile(double probability) {
  const double q = probability - 0.5;
  if (std::abs(q) <= 0.425) return q * Quotient(kA, kB, 0.180625 - q * q);
  const double r = std::sqrt(-std::log(q < 0.0 ? probability : 1.0 - probability));
  return std::copysign(r <= 5.0 ? Quotient(kC, kD, r - 1.6) : Quotient(kE, kF, r - 5.0), q);
}

}  // namespace

RangeNoise::RangeNoise(uint64_t key, double std_dev, double max_range)
    : key_(key), std_dev_(std_dev), max_range_(max_range) {
  Require(std_dev >= 0.0 && std_dev < HUGE_VAL, "a standard deviation must be 0 or more");
  Require(max_range >= 0.0 && max_range < HUGE_VAL, "a range must be 0 or more");
}

void RangeNoise::AddTo(float* ranges, int count, int64_t nanoseconds) const {
  SplitMix64 numbers(Mixed(key_ + Mixed(static_cast<uint64_t>(nanoseconds))));
  for (int i = 0; i < count; ++i) {
    const double noise = std_dev_ * NormalQuantile(numbers.Draw());
    if (std::isinf(ranges[i])) continue;
    ranges[i] = static_cast<float>(std::clamp(ranges[i] + noise, 0.0, max_range_));
  }
}

}  // namespace flatland
