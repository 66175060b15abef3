#pragma once

/// A world with a contact listener that records all events.

#include <gtest/gtest.h>

#include <functional>
#include <numeric>
#include <string>
#include <vector>

#include "test_bodies.hpp"
#include "world/contact.hpp"
#include "world/world.hpp"

namespace flatland {

inline constexpr double kSkin = 0.02;  ///< Box2D's rounded corners and slop [m]
inline constexpr ContactEvents kAllContactEvents =
    kBeginContact | kEndContact | kPreSolve | kPostSolve;

/// A contact as it was at one of its events.
struct Event {
  ContactEvent type;
  Fixture a, b;
  const void* id;
  bool is_touching, is_enabled;
  std::vector<Vec2> points;
  Vec2 normal;
  Manifold old_manifold;
  ContactImpulse impulse;
};

inline double Sum(const std::vector<double>& values) {
  return std::accumulate(values.begin(), values.end(), 0.0);
}

/// Records all events, and calls the test's action for each.
class Recorder : public ContactListener {
 public:
  void OnContact(Contact& contact) override {
    events.push_back({contact.event, contact.a, contact.b, contact.id(), contact.is_touching(),
                      contact.is_enabled(), contact.Points(), contact.Normal(),
                      contact.old_manifold, contact.impulse});
    if (action) action(contact);
  }

  // All events in their order, a letter each: (b)egin, (p)re solve, post (s)olve, (e)nd.
  std::string Story() const {
    std::string story;
    for (const Event& event : events) {
      story += event.type == kBeginContact ? 'b'
               : event.type == kEndContact ? 'e'
               : event.type == kPreSolve   ? 'p'
                                           : 's';
    }
    return story;
  }

  int Count(ContactEvent type) const {
    int count = 0;
    for (const Event& event : events) count += event.type == type;
    return count;
  }

  std::vector<Event> events;
  std::function<void(Contact&)> action;
};

inline FixtureSettings Rubber() {
  FixtureSettings settings = Solid();
  settings.restitution = 1.0;
  return settings;
}

class ContactTest : public testing::Test {
 protected:
  ContactTest() { world_.contacts().SetListener(&recorder_); }

  World::Body AddBody(const Pose& pose) { return world_.AddBody(At(pose)); }

  World::Body AddBox(const Pose& pose, const FixtureSettings& settings = Solid(),
                     b2BodyType type = b2_dynamicBody) {
    const World::Body box = world_.AddBody(At(pose, type));
    world_.AddPolygon(box, Square(1.0), settings);
    return box;
  }

  World::Body AddBall(const Pose& pose, const FixtureSettings& settings = Solid()) {
    return AddDisc(world_, pose, 0.5, settings);
  }

  World::Body AddWallAt(double x) { return world_.AddLayer({{{x, -5}, {x, 5}}}, 0xFFFF); }

  void StepTimes(int steps) { flatland::StepTimes(world_, steps); }

  Recorder recorder_;
  World world_{10, 10};
};

}  // namespace flatland
