#pragma once

/// Limits on what is passed to Box2D. Box2D checks some of its input by assertions, which end the
/// process, and does not check the rest, which then turns into NaN. So values are checked here.

#include <box2d/box2d.h>

#include <cmath>
#include <vector>

#include "base/geometry.hpp"

namespace flatland {

/// The largest coordinate [m]; single precision resolves it to about a centimetre.
constexpr double kMaxCoordinate = 1e5;
/// The smallest radius [m]; single precision loses the mass of a smaller circle.
constexpr double kMinRadius = 1e-4;
/// The smallest density above 0 [kg/m^2].
constexpr double kMinDensity = 1e-6;
/// The masses that a body may be given [kg], and its moments of inertia [kg m^2].
constexpr double kMinMass = 1e-12;
constexpr double kMaxMass = 1e12;
constexpr double kMinInertia = 1e-24;
constexpr double kMaxInertia = 1e24;
/// The shortest step [s].
constexpr double kMinStep = 1e-9;

// Each throws std::invalid_argument with the message if the condition is not met.

[[noreturn]] void Refuse(const char* message);
inline void Require(bool condition, const char* message) {
  if (!condition) Refuse(message);
}
/// A position must be finite and within kMaxCoordinate.
inline void RequirePosition(Vec2 position) {
  Require(std::abs(position.x) <= kMaxCoordinate && std::abs(position.y) <= kMaxCoordinate,
          "a position must be finite and within 100 km of the origin");
}
void RequireNotNegative(double value, const char* message);

/// True if b2PolygonShape::Set finds a hull with an area.
bool HasHull(const std::vector<b2Vec2>& vertices);

}  // namespace flatland
