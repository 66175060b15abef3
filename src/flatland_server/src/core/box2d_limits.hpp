#pragma once

/// What Box2D can digest. It checks its input by assertions, which end the process, or not at all,
/// and then goes on with NaN: so everything is checked before it gets there.

#include <box2d/box2d.h>

#include <vector>

#include "flatland_server/geometry.hpp"

namespace flatland {

/// The largest coordinate [m] that single precision still resolves to about a centimetre.
constexpr double kFarthest = 1e5;
constexpr double kLeastRadius = 1e-4;   // [m]; a smaller circle's mass is lost in single precision
constexpr double kLeastDensity = 1e-6;  // [kg/m^2] above 0
constexpr double kLeastStep = 1e-9;     // [s]

/// Each throws std::invalid_argument, with the message, if it does not hold.
void Require(bool condition, const char* message);
void RequirePlace(Vec2 place);
void RequireNotNegative(double value, const char* message);

/// Whether b2PolygonShape::Set finds a hull with an area.
bool HasHull(const std::vector<b2Vec2>& vertices);

/// Whether a body keeps a positive moment of inertia when it gets the shape too.
bool HasInertia(const b2Body& body, const b2Shape& shape, float density);

}  // namespace flatland
