#include "motion/easing.hpp"

#include <algorithm>
#include <cmath>

namespace flatland {
namespace {

// The formulas of R. Penner, "Programming Macromedia Flash MX" (2002), chapter 7, in the form that
// easings.net shows: from 0 to 1 in a time of 1. Each is given as its In; Out and InOut follow by
// symmetry.

using Curve = double (*)(double t);

/// The curve reversed in time and value: slow at the end instead of the start.
template <Curve in>
double Out(double t) {
  return 1.0 - in(1.0 - t);
}

/// In for the first half, Out for the second.
template <Curve in>
double InOut(double t) {
  return t < 0.5 ? 0.5 * in(2.0 * t) : 1.0 - 0.5 * in(2.0 - 2.0 * t);
}

double Linear(double t) { return t; }
double Quadratic(double t) { return t * t; }
double Cubic(double t) { return t * t * t; }
double Quartic(double t) { return t * t * t * t; }
double Quintic(double t) { return t * t * t * t * t; }
double Exponential(double t) { return t > 0.0 ? std::exp2(10.0 * (t - 1.0)) : 0.0; }
double Circular(double t) { return 1.0 - std::sqrt(1.0 - t * t); }

double BackBy(double overshoot, double t) { return t * t * ((overshoot + 1.0) * t - overshoot); }
double Back(double t) { return BackBy(1.70158, t); }  // overshoots by a tenth of the way
double BackOfInOut(double t) { return BackBy(1.70158 * 1.525, t); }

/// A growing oscillation of amplitude 1 at t = 1.
double ElasticOf(double period, double t) {
  if (t <= 0.0) return 0.0;
  return -Exponential(t) * std::sin((t - 1.0 - 0.25 * period) * 2.0 * M_PI / period);
}
double Elastic(double t) { return ElasticOf(0.3, t); }
double ElasticOfInOut(double t) { return ElasticOf(0.45, t); }

/// A fall and three bounces: parabolas with half widths of 1, 1/2, 1/4 and 1/8, in units of 1/2.75.
double BounceOut(double t) {
  constexpr double kSteepness = 2.75 * 2.75;
  const auto parabola = [&](double middle, double least) {
    return kSteepness * (t - middle / 2.75) * (t - middle / 2.75) + least;
  };
  if (t < 1.0 / 2.75) return parabola(0.0, 0.0);
  if (t < 2.0 / 2.75) return parabola(1.5, 0.75);
  if (t < 2.5 / 2.75) return parabola(2.25, 0.9375);
  return parabola(2.625, 0.984375);
}
double Bounce(double t) { return 1.0 - BounceOut(1.0 - t); }

// clang-format off
constexpr std::array<Curve, kEasingCount> kCurves = {
    Linear,
    Quadratic,   Out<Quadratic>,   InOut<Quadratic>,
    Cubic,       Out<Cubic>,       InOut<Cubic>,
    Quartic,     Out<Quartic>,     InOut<Quartic>,
    Quintic,     Out<Quintic>,     InOut<Quintic>,
    Exponential, Out<Exponential>, InOut<Exponential>,
    Circular,    Out<Circular>,    InOut<Circular>,
    Back,        Out<Back>,        InOut<BackOfInOut>,
    Elastic,     Out<Elastic>,     InOut<ElasticOfInOut>,
    Bounce,      BounceOut,        InOut<Bounce>,
};
// clang-format on

}  // namespace

// clang-format off
const std::array<std::string_view, kEasingCount> kEasingNames = {
    "linear",
    "quadraticIn",   "quadraticOut",   "quadraticInOut",
    "cubicIn",       "cubicOut",       "cubicInOut",
    "quarticIn",     "quarticOut",     "quarticInOut",
    "quinticIn",     "quinticOut",     "quinticInOut",
    "exponentialIn", "exponentialOut", "exponentialInOut",
    "circularIn",    "circularOut",    "circularInOut",
    "backIn",        "backOut",        "backInOut",
    "elasticIn",     "elasticOut",     "elasticInOut",
    "bounceIn",      "bounceOut",      "bounceInOut",
};
// clang-format on

std::optional<Easing> FindEasing(std::string_view name) {
  const auto found = std::find(kEasingNames.begin(), kEasingNames.end(), name);
  if (found == kEasingNames.end()) return std::nullopt;
  return static_cast<Easing>(found - kEasingNames.begin());
}

double Ease(Easing easing, double t) {
  // Exact at both ends, whatever the rounding errors.
  if (t <= 0.0) return 0.0;
  if (t >= 1.0) return 1.0;
  return kCurves[static_cast<size_t>(easing)](t);
}

}  // namespace flatland
