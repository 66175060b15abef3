#pragma once

/// Fixtures: the shapes of a body, with their material and their collision layers.
///
/// Box2D asserts on some invalid shapes, which ends the process, and computes NaN from others. So
/// every shape is checked before Box2D gets it, by the functions of this file.

#include <box2d/box2d.h>

#include <cstdint>
#include <vector>

#include "base/collision_layers.hpp"
#include "base/geometry.hpp"
#include "base/slot_map.hpp"

namespace flatland {

struct BodyRecord;

/// Handle of a fixture.
struct Fixture {
  Handle<BodyRecord> body;
  uint32_t index = 0;  ///< among the body's fixtures, or a layer's walls, in the order of creation

  bool operator==(const Fixture& other) const { return body == other.body && index == other.index; }
};

struct FixtureSettings {
  double density = 0.0;           ///< [kg/m^2]; 0, or 1e-6 and more
  double friction = 0.0;          ///< Box2D's coefficient, 0 or more
  double restitution = 0.0;       ///< Box2D's coefficient, 0 or more
  bool sensor = false;            ///< reports contacts, but passes through everything
  bool collides = true;           ///< false: no contacts at all, but visible to lidars
  bool visible = true;            ///< true if lidars see it
  LayerBits layers = kAllLayers;  ///< collides with and is seen by what shares one of these
};

// Each function below throws std::invalid_argument if Box2D cannot take the value.

/// A disc of a radius of 0.1 mm to 100 km [m], in the body's frame.
b2CircleShape MakeCircle(Vec2 center, double radius);

/// The convex hull of 3 to 8 vertices [m], in the body's frame. It must have an area.
b2PolygonShape MakePolygon(const std::vector<Vec2>& vertices);

/// Checks density, friction and restitution.
void RequireMaterial(const FixtureSettings& settings);

/// Mass properties of a fixture, for MassSum.
b2MassData ComputeMass(const b2Shape& shape, double density);

/// Throws std::invalid_argument with the message unless a body of this mass has a positive moment
/// of inertia about its centre of mass, which Box2D asserts: rounding may leave none.
void RequireInertia(const b2MassData& mass, const char* message);

/// The mass properties of a body, summed up fixture by fixture.
///
/// Box2D sums over all fixtures of a body each time that one with a density is added to it, which
/// takes minutes for a body of some ten thousand. So AddFixture sets a body's mass by this sum.
class MassSum {
 public:
  /// The sum with one more fixture. Throws unless a dynamic body with these fixtures has an inertia
  /// (RequireInertia). A small shape far from the origin may have none.
  MassSum With(const b2MassData& fixture) const;
  /// For b2Body::SetMassData.
  b2MassData ToBox2D() const;

 private:
  double mass_ = 0.0;     // [kg]
  double inertia_ = 0.0;  // about the body's origin [kg m^2]
  Vec2 moment_;           // of mass, about the body's origin [kg m]
};

}  // namespace flatland
