#pragma once

/// Rigid bodies.

#include <box2d/box2d.h>

#include <vector>

#include "base/geometry.hpp"
#include "world/contact.hpp"

namespace flatland {

struct BodySettings {
  b2BodyType type = b2_dynamicBody;
  Pose pose;                     ///< of the body's origin, in the world [m, m, rad]
  double linear_damping = 0.0;   ///< [1/s]
  double angular_damping = 0.0;  ///< [1/s]
};

/// A body in a World, or the static body that holds a layer's walls.
struct BodyRecord {
  struct FixtureRecord {
    b2Fixture* fixture = nullptr;
    bool visible = true;       // to lidars
    double seen_radius = 0.0;  // of its bounding circle, as lidars see it [m]; see VisibleFixture
    bool collides = true;      // on its layers
  };

  /// The walls that Box2D has for a dynamic body; see Layers.
  struct Nearby {
    struct Block {
      uint32_t layer = 0;
      uint32_t number = 0;

      template <class Archive>
      void Serialize(Archive& archive) {
        archive(layer, number);
      }
    };

    bool is_current = false;      // false: they must be looked up again
    b2Vec2 center = b2Vec2_zero;  // of mass, when they were looked up [m]
    float room = 0.0f;            // how far it may be from there, along either axis [m]
    std::vector<Block> blocks;    // in ascending order
  };

  /// Gives a dynamic body a mass. Box2D rounds the inertia when it is set. So it is set a second
  /// time, as GetMassData returns it: then a body that is restored from GetMassData has the same
  /// bits.
  void SetMass(b2MassData data) const {
    body->SetMassData(&data);
    body->GetMassData(&data);
    body->SetMassData(&data);
  }
  /// Gives a dynamic body the mass of its fixtures. Box2D takes 1 kg, and a centre at the origin,
  /// if they have none; a body that never gets a mass would pass through walls.
  void ResetMass() const { SetMass(mass.ToBox2D()); }

  b2Body* body = nullptr;
  bool is_layer = false;
  uint32_t layer = 0;      // its number among the layers
  bool is_person = false;  // of a crowd
  bool may_move = true;    // false: it stays where it is, unless World::SetPose moves it
  ContactEvents contact_events = kNoContactEvents;  // that the contact listener receives
  bool is_recorded = false;                         // its collisions are recorded
  std::vector<FixtureRecord> fixtures;              // by Fixture::index; a layer has none here
  MassSum mass;                                     // of the fixtures, for a dynamic body
  Nearby nearby;
};

}  // namespace flatland
