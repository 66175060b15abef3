#pragma once

/// The state of a World: what it keeps from step to step. Internal to the core.

#include <box2d/box2d.h>

#include <array>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <string>
#include <string_view>
#include <vector>

#include "people/crowd.hpp"
#include "world/mechanisms.hpp"
#include "world/saved_tree.hpp"

namespace flatland {

class World;

struct Material {
  float friction = 0.0f;
  float restitution = 0.0f;

  bool operator==(const Material& other) const {
    return friction == other.friction && restitution == other.restitution;
  }
  template <class Archive>
  void Serialize(Archive& archive) {
    archive(friction, restitution);
    if constexpr (Archive::kIsReader) {
      if (friction < 0.0f || restitution < 0.0f) Archive::Fail();
    }
  }
};

/// The material of walls at first: Box2D's default.
constexpr Material kDefaultMaterial{0.2f, 0.0f};

struct BodyState {
  b2Vec2 position = b2Vec2_zero;  // of the origin [m]
  b2Sweep sweep{};                // the centre of mass and the angle, now and before the last step
  b2Vec2 velocity = b2Vec2_zero;  // of the centre of mass [m/s]
  float omega = 0.0f;             // [rad/s]
  b2Vec2 force = b2Vec2_zero;     // applied since the last step [N]
  float torque = 0.0f;            // the same [N m]
  float sleep_time = 0.0f;        // for how long it has been at rest [s]
  bool is_awake = true;
  b2MassData mass{};
  std::vector<Material> materials;  // of its fixtures, or a single one if all are equal
  std::vector<uint32_t> order;      // of its fixtures in Box2D's list: their indices
  std::vector<b2AABB> boxes;        // around each of its fixtures, in this order, in the last step
  BodyRecord::Nearby nearby;

  template <class Archive>
  void Serialize(Archive& archive) {
    archive(position, sweep.c0, sweep.c, sweep.a0, sweep.a, velocity, omega);
    archive(force, torque, sleep_time, is_awake);
    // As bits: the mass of a heavy body may be above the limit for numbers, see IsUsable.
    std::array<uint32_t, 4> bits;
    static_assert(sizeof bits == sizeof mass);
    std::memcpy(&bits, &mass, sizeof mass);
    for (uint32_t& each : bits) archive(each);
    if constexpr (Archive::kIsReader) {
      std::memcpy(static_cast<void*>(&mass), &bits, sizeof mass);
      const float about_center = mass.I - mass.mass * b2Dot(mass.center, mass.center);
      const bool has_inertia = about_center > 0.0f && std::isfinite(about_center);
      const bool is_sound =
          std::isfinite(mass.mass) && (mass.I == 0.0f || (has_inertia && mass.mass > 0.0f));
      if (sleep_time < 0.0f || mass.mass < 0.0f || !is_sound) Archive::Fail();
    }
  }
};

/// For a weld, only the impulses are used. For a friction joint, `impulses` has two linear ones,
/// the angular one, and the limits of force and torque.
struct JointState {
  std::array<float, 5> impulses{};  // the solver's
  bool has_limits = false;
  float lower = 0.0f;  // [rad]
  float upper = 0.0f;
  bool has_motor = false;
  float speed = 0.0f;       // of the motor [rad/s]
  float max_torque = 0.0f;  // [N m]

  template <class Archive>
  void Serialize(Archive& archive) {
    for (float& impulse : impulses) archive(impulse);
    archive(has_limits, lower, upper, has_motor, speed, max_torque);
    if constexpr (Archive::kIsReader) {
      if (lower > upper || max_torque < 0.0f) Archive::Fail();
    }
  }
};

struct ContactState {
  struct End {
    uint32_t body = 0;  // its place in the order in which bodies were added
    uint32_t fixture = 0;

    template <class Archive>
    void Serialize(Archive& archive) {
      archive(body, fixture);
    }
  };

  End a;
  End b;
  bool is_touching = false;
  bool is_enabled = true;
  bool needs_filtering = false;  // Box2D has to check again whether they may collide
  float friction = 0.0f;
  float restitution = 0.0f;
  float tangent_speed = 0.0f;
  b2Manifold manifold{};

  template <class Archive>
  void Serialize(Archive& archive) {
    archive(a, b, is_touching, is_enabled, needs_filtering, friction, restitution, tangent_speed);
    archive(manifold.pointCount);
    if constexpr (Archive::kIsReader) {
      if (friction < 0.0f || restitution < 0.0f) Archive::Fail();
      if (manifold.pointCount < 0 || manifold.pointCount > b2_maxManifoldPoints) Archive::Fail();
    }
    if (manifold.pointCount == 0) return;  // the rest is not initialised
    uint32_t type = manifold.type;
    archive(type, manifold.localNormal, manifold.localPoint);
    if constexpr (Archive::kIsReader) {
      if (type > b2Manifold::e_faceB) Archive::Fail();
      manifold.type = static_cast<b2Manifold::Type>(type);
    }
    for (int32 i = 0; i < manifold.pointCount; ++i) {
      b2ManifoldPoint& point = manifold.points[i];
      archive(point.localPoint, point.normalImpulse, point.tangentImpulse, point.id.key);
      if constexpr (Archive::kIsReader) {
        if (point.normalImpulse < 0.0f) Archive::Fail();  // the solver asserts that it is not
      }
    }
  }
};

struct WorldState {
  static WorldState Of(const World& world);
  /// A state out of bytes. Throws std::invalid_argument if they are damaged, or of another world.
  static WorldState Read(std::string_view bytes, const World& world);
  std::string Write(const World& world);
  /// Puts a world into this state.
  void Restore(World& world) const;
  /// Removes from Box2D what was made by steps: contacts, and the walls near bodies.
  static void Clear(World& world);
  /// True if no body has come near walls yet, as before the first step.
  bool IsApartFromWalls() const;
  /// Throws std::invalid_argument unless the world has the same materials as this state, and the
  /// bodies that stay are at the same places.
  void RequireSameStill(const World& world) const;

  float inverse_step = 0.0f;      // one over the length of the last step [1/s]
  bool has_new_contacts = false;  // something was moved since
  std::vector<BodyState> bodies;  // each in the order in which they were added
  std::vector<JointState> joints;
  std::vector<ContactState> contacts;  // in Box2D's order: the newest first
  Mechanisms mechanisms;
  SlotMap<Crowd> crowds{"crowd"};
  SavedTree tree;

 private:
  template <class Archive>
  void Serialize(Archive& archive, const World& world);
};

}  // namespace flatland
