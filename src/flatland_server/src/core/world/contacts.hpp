#pragma once

/// The contacts of a world. Box2D reports all of them; those that a body has chosen are passed on
/// to the world's listener.

#include <box2d/box2d.h>

#include <cstdint>
#include <functional>
#include <memory>
#include <utility>
#include <vector>

#include "base/access.hpp"
#include "world/bodies.hpp"
#include "world/collisions.hpp"
#include "world/contact.hpp"

namespace flatland {

class Contacts : private b2ContactListener {
 public:
  /// The world's access, bodies and Box2D's world must live as long.
  Contacts(Access& access, Bodies& bodies, const std::unique_ptr<b2World>& world)
      : access_(access), bodies_(bodies), world_(world), collisions_(bodies) {}
  Contacts(const Contacts&) = delete;
  Contacts& operator=(const Contacts&) = delete;

  /// Sets the listener that receives contact events, or null. The caller keeps it alive as long as
  /// the world, or until another one is set.
  void SetListener(ContactListener* listener);
  ContactListener* listener() const { return listener_; }
  /// Chooses the events of a body's contacts that the listener receives; none at first. A contact's
  /// event is reported if either of its two bodies has chosen it.
  void ListenTo(Bodies::Body body, ContactEvents events);
  /// Records the collisions of a body from now on.
  void Record(Bodies::Body body);
  Collisions& collisions() {
    access_.RequireAccess();
    return collisions_;
  }
  /// Number of events that the listener has received.
  uint64_t event_count() const { return event_count_; }
  /// The fixtures that touch, as the last step has found them, ordered by their bodies and indices.
  std::vector<Touch> GetTouches() const;
  /// True if a solid fixture of one of these bodies touches a solid fixture of another body, as the
  /// last step has found it.
  bool Touches(const std::vector<Bodies::Body>& bodies) const;

  /// Calls an action after the step, if its body still exists. During a step the listener cannot
  /// apply forces itself: Box2D clears them at the end of the step.
  void Defer(Bodies::Body body, std::function<void(b2Body&)> action) {
    deferred_.emplace_back(body, std::move(action));
  }
  /// To be called at the end of each step [s].
  void EndStep(double dt);
  void RunDeferred();
  /// Makes Box2D report contacts if a body has chosen an event, or its collisions are recorded.
  void ChooseReports();

 private:
  void BeginContact(b2Contact* contact) override;
  void EndContact(b2Contact* contact) override;
  void PreSolve(b2Contact* contact, const b2Manifold* old_manifold) override;
  void PostSolve(b2Contact* contact, const b2ContactImpulse* impulse) override;
  /// True if there is a listener and one of the two bodies has chosen the event.
  bool IsListenedTo(b2Contact& contact, ContactEvent event) const;
  bool IsRecorded(b2Contact& contact) const;
  Contact MakeContact(b2Contact& contact, ContactEvent event) const;
  void CallListener(Contact& contact);

  Access& access_;
  Bodies& bodies_;
  const std::unique_ptr<b2World>& world_;
  ContactListener* listener_ = nullptr;
  uint64_t event_count_ = 0;
  Collisions collisions_;
  std::vector<std::pair<Bodies::Body, std::function<void(b2Body&)>>> deferred_;
};

}  // namespace flatland
