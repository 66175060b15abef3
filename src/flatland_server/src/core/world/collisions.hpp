#pragma once

/// Records what chosen bodies collided with in the last step.
///
/// A record in the core costs nothing while nothing touches, unlike a contact listener in Python.

#include <cstdint>
#include <vector>

#include "world/bodies.hpp"

namespace flatland {

/// Two fixtures that collide, or one of which is a sensor that the other passes through.
struct Collision {
  uint64_t number = 0;  ///< increases from one begin to the next
  Fixture a;
  Fixture b;
  bool has_sensor = false;
  /// Up to two, in the world [m], when they were last solved; none with a sensor.
  std::vector<Vec2> points;
  Vec2 normal;  ///< unit vector from a to b, in the world's frame; zero with a sensor
  /// At each point, of the last step [N s]; none while both bodies rest.
  std::vector<double> impulses;
};

class Collisions {
 public:
  explicit Collisions(const Bodies& bodies) : bodies_(bodies) {}

  /// The collisions of the last step: first those that continue, ordered by number, then those that
  /// ended in the step.
  const std::vector<Collision>& last() const { return last_; }
  /// Length of that step [s].
  double last_step() const { return last_step_; }
  /// The collisions that continue, ordered by number.
  const std::vector<Collision>& present() const { return present_; }
  /// Adds a collision that was in present() when the state was saved.
  void Restore(Collision collision);

  // Events of recorded contacts.

  void Begin(const Contact& contact, bool has_sensor);
  /// A step may solve a contact more than once: impulses add up.
  void Solve(const Contact& contact, const b2ContactImpulse& impulse);
  void End(Fixture a, Fixture b);
  /// To be called at the end of each step [s].
  void EndStep(double dt);

 private:
  std::vector<Collision>::iterator Find(Fixture a, Fixture b);
  /// True if a collision continues. A solid one continues if it was solved in this step; if not, it
  /// was disabled, unless both bodies are asleep or not dynamic.
  bool Lasts(const Collision& collision) const;

  const Bodies& bodies_;
  uint64_t count_ = 0;
  std::vector<Collision> present_;
  std::vector<Collision> ended_;  // in this step
  std::vector<Collision> last_;
  double last_step_ = 1.0;
};

}  // namespace flatland
