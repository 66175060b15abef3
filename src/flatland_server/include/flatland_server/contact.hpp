#pragma once

/// Contacts: what happens between two fixtures that touch.

#include <box2d/box2d.h>

#include <cstdint>
#include <utility>
#include <vector>

#include "flatland_server/geometry.hpp"
#include "flatland_server/slot_map.hpp"

namespace flatland {

struct BodyRecord;

/// A fixture: which one of a body's, in the order in which it got them. Of a layer, a wall.
struct Fixture {
  Handle<BodyRecord> body;
  uint32_t index = 0;
};

/// The moments at which a contact is told of; see b2ContactListener. Together, a set of them.
enum ContactHooks : uint8_t {
  kNoHooks = 0,
  kBeginContact = 1,
  kEndContact = 2,
  kPreSolve = 4,
  kPostSolve = 8,
};

/// Impulses of the solver at the points of a contact [N s].
struct ContactImpulse {
  std::vector<double> normal_impulses;
  std::vector<double> tangent_impulses;
};

/// The points of a contact as they were in the step before.
struct Manifold : ContactImpulse {
  /// In the frame of the body that Box2D reckons them in; see b2Manifold.
  std::vector<Vec2> local_points;
};

/// A contact at one of its moments. It is there only while its listener is called.
class Contact {
 public:
  Contact(b2Contact& contact, ContactHooks moment, Fixture a, Fixture b)
      : moment(moment), a(a), b(b), contact_(contact) {}

  const ContactHooks moment;
  const Fixture a;
  const Fixture b;

  /// Names the contact for as long as it lasts, from its begin to its end.
  const void* id() const { return &contact_; }
  bool is_touching() const { return contact_.IsTouching(); }
  /// False of a contact that has been switched off for this step, and with a sensor.
  bool is_enabled() const;
  /// Before it is solved: whether the two push each other apart in this step.
  void SetEnabled(bool enabled) { contact_.SetEnabled(enabled); }

  /// Where they touch, up to two points in the world [m]; none with a sensor.
  std::vector<Vec2> Points() const;
  /// Unit vector from a to b, in the world; zero where there are no points.
  Vec2 Normal() const;

  double friction() const { return contact_.GetFriction(); }
  double restitution() const { return contact_.GetRestitution(); }
  /// The surface's own speed, as of a conveyor belt [m/s].
  double tangent_speed() const { return contact_.GetTangentSpeed(); }
  // Each throws std::invalid_argument for a value that is not finite, or negative where it cannot
  // be.
  void SetFriction(double friction);
  void SetRestitution(double restitution);
  void SetTangentSpeed(double speed);

  Manifold old_manifold;   ///< at kPreSolve
  ContactImpulse impulse;  ///< at kPostSolve

 private:
  b2Contact& contact_;
};

/// Hears of contacts, while the world steps and while bodies are removed. It may look at the world,
/// set velocities, and apply forces for the next step, but add, remove or place nothing. It must
/// not throw: Box2D would be left in the middle of a step.
class ContactListener {
 public:
  virtual ~ContactListener() = default;
  virtual void OnContact(Contact& contact) = 0;
};

}  // namespace flatland
