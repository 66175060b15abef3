#pragma once

/// Normally distributed random numbers.
///
/// Uniform numbers: Steele, Lea and Flood, "Fast splittable pseudorandom number generators",
/// OOPSLA 2014 (SplitMix64). Their normal quantiles: Wichura, "Algorithm AS 241: The percentage
/// points of the normal distribution", Applied Statistics 37, 1988 (PPND7, to 7 digits).

#include <cmath>
#include <cstdint>

namespace flatland {

/// Numbers of mean 0 and standard deviation 1. Equal states give equal numbers.
class NormalNumbers {
 public:
  explicit NormalNumbers(uint64_t state = 0) : state_(state) {}

  double Draw() { return Quantile(DrawUniform()); }
  /// Between 0 and 1, neither of them included.
  double DrawUniform() {
    state_ += 0x9e3779b97f4a7c15u;
    return (static_cast<double>(Mixed(state_) >> 11) + 0.5) * 0x1p-53;
  }

  /// Scrambles the bits of a number.
  static uint64_t Mixed(uint64_t z) {
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
    return z ^ (z >> 31);
  }

  /// Writes or reads the state; see archive.hpp.
  template <class Archive>
  void Serialize(Archive& archive) {
    archive(state_);
  }

 private:
  /// A quotient of polynomials; the first coefficient is that of the constant.
  template <int n, int m>
  static double Quotient(const double (&above)[n], const double (&below)[m], double x) {
    double numerator = above[n - 1], denominator = below[m - 1];
    for (int i = n - 2; i >= 0; --i) numerator = numerator * x + above[i];
    for (int i = m - 2; i >= 0; --i) denominator = denominator * x + below[i];
    return numerator / denominator;
  }

  /// The quantile of the standard normal distribution: the inverse of its distribution function.
  static double Quantile(double probability) {
    constexpr double kA[] = {3.3871327179, 50.434271938, 159.29113202, 59.109374720};
    constexpr double kB[] = {1.0, 17.895169469, 78.757757664, 67.187563600};
    constexpr double kC[] = {1.4234372777, 2.7568153900, 1.3067284816, 0.17023821103};
    constexpr double kD[] = {1.0, 0.73700164250, 0.12021132975};
    constexpr double kE[] = {6.6579051150, 3.0812263860, 0.42868294337, 0.017337203997};
    constexpr double kF[] = {1.0, 0.24197894225, 0.012258202635};
    const double q = probability - 0.5;
    if (std::abs(q) <= 0.425) return q * Quotient(kA, kB, 0.180625 - q * q);
    const double r = std::sqrt(-std::log(q < 0.0 ? probability : 1.0 - probability));
    return std::copysign(r <= 5.0 ? Quotient(kC, kD, r - 1.6) : Quotient(kE, kF, r - 5.0), q);
  }

  uint64_t state_;
};

}  // namespace flatland
