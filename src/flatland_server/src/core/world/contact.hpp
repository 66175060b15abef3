#pragma once

/// Contacts: pairs of fixtures that touch, and the events of a contact.

#include <box2d/box2d.h>

#include <cstdint>
#include <vector>

#include "base/geometry.hpp"
#include "world/fixture.hpp"

namespace flatland {

/// An event in the life of a contact; see b2ContactListener.
enum ContactEvent : uint8_t {
  kBeginContact = 1,  ///< the two begin to touch
  kEndContact = 2,    ///< the two cease to touch, or one of them is removed
  kPreSolve = 4,      ///< in each step, before the solver; not with a sensor
  kPostSolve = 8,     ///< in each step, after the solver; not with a sensor
};

/// A set of events: a bitwise or of ContactEvent.
using ContactEvents = uint8_t;
constexpr ContactEvents kNoContactEvents = 0;

/// The solver's impulses at each point of a contact [N s].
struct ContactImpulse {
  std::vector<double> normal_impulses;
  std::vector<double> tangent_impulses;
};

/// The points of a contact in the previous step, with their impulses.
struct Manifold : ContactImpulse {
  /// Up to two points in the frame of the reference body that Box2D chose [m]; see b2Manifold.
  std::vector<Vec2> local_points;
};

/// A contact at one of its events. Valid only during the listener's call.
class Contact {
 public:
  Contact(b2Contact& contact, ContactEvent event, Fixture a, Fixture b)
      : event(event), a(a), b(b), contact_(contact) {}

  const ContactEvent event;
  const Fixture a;
  const Fixture b;

  /// Identifies the contact from its begin to its end.
  const void* id() const { return &contact_; }
  bool is_touching() const { return contact_.IsTouching(); }
  /// True if the two push each other apart in this step: neither is a sensor, and it is enabled.
  bool is_enabled() const;
  /// In kPreSolve: whether the two push each other apart in this step.
  void SetEnabled(bool enabled) { contact_.SetEnabled(enabled); }

  /// Where they touch: up to two points in the world [m], none with a sensor.
  std::vector<Vec2> Points() const;
  /// Unit vector from a to b in the world's frame; zero if there are no points.
  Vec2 Normal() const;

  double friction() const { return contact_.GetFriction(); }
  double restitution() const { return contact_.GetRestitution(); }
  /// Speed of the surface itself, as of a conveyor belt [m/s].
  double tangent_speed() const { return contact_.GetTangentSpeed(); }
  // Each throws std::invalid_argument if the value is not finite. The first two also if it is
  // negative.
  void SetFriction(double friction);
  void SetRestitution(double restitution);
  void SetTangentSpeed(double speed);

  Manifold old_manifold;   ///< of the previous step; in kPreSolve only
  ContactImpulse impulse;  ///< of this step; in kPostSolve only

 private:
  b2Contact& contact_;
};

/// Two fixtures that touch, as the last step has found them.
struct Touch {
  Fixture a;
  Fixture b;
  std::vector<Vec2> points;  ///< up to two, in the world [m]; none with a sensor
  Vec2 normal;               ///< unit vector from a to b, in the world's frame; zero with a sensor
};

/// Receives the contact events of a world, within World::Step and World::RemoveBody.
///
/// It may query the world, set velocities and apply forces, which then count for the next step. It
/// must not add, remove or move anything, and must not throw: Box2D would be left within a step.
class ContactListener {
 public:
  virtual ~ContactListener() = default;
  virtual void OnContact(Contact& contact) = 0;
};

}  // namespace flatland
