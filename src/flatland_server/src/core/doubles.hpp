#pragma once

/// Arithmetic on a few numbers at a time, for one source file that needs it. The compiler makes of
/// it what the processor has.

#include <cmath>
#include <cstring>

#include "flatland_server/beam_fan.hpp"

// Compiled twice, and the right one taken at run time: the default build runs on any processor.
#if defined(__x86_64__) && defined(__GNUC__) && !defined(__clang__)
#define FLATLAND_CLONES __attribute__((target_clones("avx2", "default")))
#else
#define FLATLAND_CLONES
#endif
// What is called from there belongs to both.
#define FLATLAND_INLINE __attribute__((always_inline)) inline

namespace flatland {

constexpr int kGroup = BeamFan::kGroup;

/// A few numbers at a time; the compiler makes of it what the processor has. Comparisons give
/// masks.
using Doubles = double __attribute__((vector_size(kGroup * sizeof(double))));
using Mask = long long __attribute__((vector_size(kGroup * sizeof(long long))));
static_assert(kGroup == 4, "Fill names its numbers");

FLATLAND_INLINE Doubles Fill(double value) { return Doubles{value, value, value, value}; }

FLATLAND_INLINE Doubles Load(const double* values) {
  Doubles loaded;
  std::memcpy(&loaded, values, sizeof(loaded));
  return loaded;
}

FLATLAND_INLINE void Store(const Doubles& stored, double* values) {
  std::memcpy(values, &stored, sizeof(stored));
}

FLATLAND_INLINE bool Any(const Mask& mask) { return (mask[0] | mask[1] | mask[2] | mask[3]) != 0; }

FLATLAND_INLINE Doubles Sqrt(const Doubles& values) {
  Doubles roots;
  for (int k = 0; k < kGroup; ++k) roots[k] = std::sqrt(values[k]);
  return roots;
}

/// Not less than the vectors' lengths.
FLATLAND_INLINE Doubles Sizes(const Doubles& x, const Doubles& y) {
  return (x < 0.0 ? -x : x) + (y < 0.0 ? -y : y);
}
inline double Size(Vec2 v) { return std::abs(v.x) + std::abs(v.y); }

FLATLAND_INLINE Doubles DiamondAngles(const Doubles& x, const Doubles& y) {
  const Doubles slant = y / Sizes(x, y);
  return x >= 0.0 ? slant : (y >= 0.0 ? 2.0 - slant : -2.0 - slant);
}

}  // namespace flatland
