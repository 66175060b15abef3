#pragma once

/// Easings: functions from the elapsed fraction of the time to the covered fraction of the way.

#include <array>
#include <optional>
#include <string_view>

namespace flatland {

/// Linear, and nine families, each slow at the start (In), at the end (Out) or at both (InOut).
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

/// The names of the easings in YAML, in the order of the enumeration.
extern const std::array<std::string_view, kEasingCount> kEasingNames;

/// The easing of this name, or nothing.
std::optional<Easing> FindEasing(std::string_view name);

/// The covered fraction of the way when the fraction `t` of the time has elapsed. Exactly 0 for
/// t <= 0, and exactly 1 for t >= 1. Between, Back and Elastic also leave [0, 1].
double Ease(Easing easing, double t);

}  // namespace flatland
