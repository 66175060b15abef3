#pragma once

/// Arithmetic on four numbers at a time, and on eight in single precision (SIMD).

#include <cmath>
#include <cstdint>
#include <cstring>

#include "sight/beam_fan.hpp"

// Compiles a function twice, with AVX2 and without, and chooses between them at run time.
#if defined(__x86_64__) && defined(__GNUC__) && !defined(__clang__)
#define FLATLAND_CLONES __attribute__((target_clones("avx2", "default")))
#else
#define FLATLAND_CLONES
#endif
// Functions and lambdas called by those must be inlined, to be compiled for AVX2 too.
#define FLATLAND_INLINED __attribute__((always_inline))
#define FLATLAND_INLINE FLATLAND_INLINED inline

namespace flatland {

constexpr int kGroup = BeamFan::kGroup;

/// Vectors of numbers, and of the results of comparisons: -1 for true, 0 for false.
using Doubles = double __attribute__((vector_size(kGroup * sizeof(double))));
using Mask = long long __attribute__((vector_size(kGroup * sizeof(long long))));
using Floats = float __attribute__((vector_size(kGroup * sizeof(float))));
using Ints = int __attribute__((vector_size(kGroup * sizeof(int))));
static_assert(kGroup == 4, "Fill lists four numbers");

/// The same for eight numbers in single precision.
constexpr int kEight = 8;
using EightFloats = float __attribute__((vector_size(kEight * sizeof(float))));
using EightInts = int __attribute__((vector_size(kEight * sizeof(int))));

FLATLAND_INLINE Doubles Fill(double value) { return Doubles{value, value, value, value}; }

FLATLAND_INLINE Doubles Load(const double* values) {
  Doubles loaded;
  std::memcpy(&loaded, values, sizeof(loaded));
  return loaded;
}

FLATLAND_INLINE EightFloats FillEight(float v) { return EightFloats{v, v, v, v, v, v, v, v}; }
FLATLAND_INLINE EightFloats Load(const float* values) {
  EightFloats loaded;
  std::memcpy(&loaded, values, sizeof(loaded));
  return loaded;
}

template <class Vector, class T>
FLATLAND_INLINE void Store(const Vector& stored, T* values) {
  std::memcpy(values, &stored, sizeof(stored));
}

/// Turns the rows of a matrix into its columns.
FLATLAND_INLINE void Transpose(Doubles (&rows)[kGroup]) {
#ifdef __clang__
#define FLATLAND_SHUFFLE(a, b, ...) __builtin_shufflevector(a, b, __VA_ARGS__)
#else
#define FLATLAND_SHUFFLE(a, b, ...) __builtin_shuffle(a, b, Mask{__VA_ARGS__})
#endif
  const Doubles even_low = FLATLAND_SHUFFLE(rows[0], rows[1], 0, 4, 2, 6);
  const Doubles odd_low = FLATLAND_SHUFFLE(rows[0], rows[1], 1, 5, 3, 7);
  const Doubles even_high = FLATLAND_SHUFFLE(rows[2], rows[3], 0, 4, 2, 6);
  const Doubles odd_high = FLATLAND_SHUFFLE(rows[2], rows[3], 1, 5, 3, 7);
  rows[0] = FLATLAND_SHUFFLE(even_low, even_high, 0, 1, 4, 5);
  rows[1] = FLATLAND_SHUFFLE(odd_low, odd_high, 0, 1, 4, 5);
  rows[2] = FLATLAND_SHUFFLE(even_low, even_high, 2, 3, 6, 7);
  rows[3] = FLATLAND_SHUFFLE(odd_low, odd_high, 2, 3, 6, 7);
#undef FLATLAND_SHUFFLE
}

FLATLAND_INLINE Floats ToFloats(const Doubles& values) {
  return __builtin_convertvector(values, Floats);
}

/// Whole parts of numbers that an int can hold.
FLATLAND_INLINE Ints ToInts(const Doubles& values) { return __builtin_convertvector(values, Ints); }
FLATLAND_INLINE EightInts ToInts(const EightFloats& values) {
  return __builtin_convertvector(values, EightInts);
}

FLATLAND_INLINE bool Any(const Mask& mask) { return (mask[0] | mask[1] | mask[2] | mask[3]) != 0; }

/// The smaller ones, and the larger ones, of two numbers each; the second if one is NaN.
FLATLAND_INLINE Doubles Min(const Doubles& a, const Doubles& b) { return a < b ? a : b; }
FLATLAND_INLINE Doubles Max(const Doubles& a, const Doubles& b) { return a > b ? a : b; }
FLATLAND_INLINE EightFloats Min(const EightFloats& a, const EightFloats& b) {
  return a < b ? a : b;
}
FLATLAND_INLINE EightFloats Max(const EightFloats& a, const EightFloats& b) {
  return a > b ? a : b;
}

FLATLAND_INLINE Doubles Sqrt(const Doubles& values) {
  Doubles roots;
  for (int k = 0; k < kGroup; ++k) roots[k] = std::sqrt(values[k]);
  return roots;
}

/// Without the sign bits.
FLATLAND_INLINE Doubles Abs(const Doubles& values) { return (Doubles)((Mask)values & INT64_MAX); }

/// Upper bounds of the vectors' lengths.
FLATLAND_INLINE Doubles ManhattanNorms(const Doubles& x, const Doubles& y) {
  return Abs(x) + Abs(y);
}
inline double ManhattanNorm(Vec2 v) { return std::abs(v.x) + std::abs(v.y); }

FLATLAND_INLINE EightFloats DiamondAngles(const EightFloats& x, const EightFloats& y) {
  const auto abs = [](const EightFloats& v) { return (EightFloats)((EightInts)v & INT32_MAX); };
  const EightFloats slant = y / (abs(x) + abs(y));
  return x >= 0.0f ? slant : (y >= 0.0f ? 2.0f - slant : -2.0f - slant);
}
FLATLAND_INLINE Doubles DiamondAngles(const Doubles& x, const Doubles& y) {
  const Doubles slant = y / ManhattanNorms(x, y);
  return x >= 0.0 ? slant : (y >= 0.0 ? 2.0 - slant : -2.0 - slant);
}

}  // namespace flatland
