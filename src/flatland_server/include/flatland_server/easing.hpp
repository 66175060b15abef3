#pragma once

/// Easings: how far a movement has got when a part of its time is over.

#include <array>
#include <optional>
#include <string_view>

namespace flatland {

/// Linear, and nine families that are slow at the start (In), at the end (Out) or at both (InOut).
enum class Easing {
  kLinear,
  kQuadraticIn,
  kQuadraticOut,
  kQuadraticInOut,
  kCubicIn,
  kCubicOut,
  kCubicInOut,
  kQuarticIn,
  kQuarticOut,
  kQuarticInOut,
  kQuinticIn,
  kQuinticOut,
  kQuinticInOut,
  kExponentialIn,
  kExponentialOut,
  kExponentialInOut,
  kCircularIn,
  kCircularOut,
  kCircularInOut,
  kBackIn,
  kBackOut,
  kBackInOut,
  kElasticIn,
  kElasticOut,
  kElasticInOut,
  kBounceIn,
  kBounceOut,
  kBounceInOut,
};

constexpr int kEasingCount = 28;

/// Their names in YAML, in the order of the enumeration.
extern const std::array<std::string_view, kEasingCount> kEasingNames;

/// The easing of that name, if there is one.
std::optional<Easing> FindEasing(std::string_view name);

/// The part of the way made when the part `t` of the time is over: exactly 0 at 0 (and before), and
/// exactly 1 at 1 (and after). Back and elastic leave [0, 1] in between.
double Ease(Easing easing, double t);

}  // namespace flatland
