/// Construction and stepping. The other parts of World are in world_*.cpp, one file for
/// each group of functions in world.hpp.

#include "world/world.hpp"

#include <algorithm>
#include <cmath>

#include "base/box2d_internals.hpp"
#include "base/box2d_limits.hpp"
#include "base/to_box2d.hpp"
#include "world/layers.hpp"

namespace flatland {
namespace {

/// Takes whole rotations off a body's angle. Box2D keeps angles in single precision: after an hour
/// of spinning, the rotation of one step would be lost in rounding.
void Unwind(b2Body& body) {
  if (IsWound(body)) AddRotations(body, -std::round(body.GetAngle() / kFullRotation));
}

}  // namespace

World::World(int velocity_iterations, int position_iterations, float room)
    : world_(std::make_unique<b2World>(b2Vec2_zero)),
      velocity_iterations_(velocity_iterations),
      position_iterations_(position_iterations),
      layers_(std::make_unique<Layers>(bodies_, room)),
      lidars_(*this, bodies_, *layers_),
      contacts_(*this, bodies_, world_) {
  Require(velocity_iterations >= 1 && position_iterations >= 1,
          "a solver needs at least one iteration");
  world_->SetDestructionListener(this);
}

World::~World() = default;

void World::Step(double dt, const AccessGuard&) {
  Require(IsUsable(dt) && dt >= kMinStep, "a step must be finite and longer than zero");
  const int parts = PartsOf(dt);
  if (parts == 1) return StepOnce(dt);
  world_->SetAutoClearForces(false);                    // forces act in all parts of the step
  const double nanoseconds = std::nearbyint(dt * 1e9);  // drives and drifts count whole ones
  const auto end_of = [=](int part) { return std::floor(nanoseconds * part / parts); };
  for (int i = 0; i < parts; ++i) StepOnce((end_of(i + 1) - end_of(i)) * 1e-9);
  world_->ClearForces();
  world_->SetAutoClearForces(true);
}

int World::PartsOf(double dt) {
  const auto is_fast = [dt](double squared_speed, double omega) {
    const double turn = omega * dt;
    return squared_speed * dt * dt > b2_maxTranslationSquared || turn > b2_maxRotation;
  };
  double most = 1.0;  // greatest motion, in multiples of what is possible in one step
  const auto consider = [&](double speed, double omega) {
    most = std::max({most, speed * dt / b2_maxTranslation, omega * dt / b2_maxRotation});
  };
  for (const BodyRecord* record : bodies_.Moving()) {
    const b2Vec2 velocity = record->body->GetLinearVelocity();
    const double squared = b2Dot(velocity, velocity);
    const double omega = std::abs(record->body->GetAngularVelocity());
    if (is_fast(squared, omega)) consider(std::sqrt(squared), omega);
  }
  mechanisms_.ForEachDrive([&](Body body, const auto& drive) {
    const auto [squared, omega] = drive.GetFastest();
    if (!is_fast(4.0 * squared, 2.0 * omega)) return;
    const double arm = bodies_.Get(body).body->GetLocalCenter().Length();
    consider(std::sqrt(squared) + omega * arm, omega);
  });
  if (most == 1.0) return 1;
  // No part is shorter than a nanosecond.
  const double parts = std::min({std::ceil(most * (1.0 + 1e-6)), double{kMostParts}, dt * 1e9});
  return std::max(1, static_cast<int>(parts));
}

void World::StepOnce(double dt) {
  bodies_.ChangePoses();
  const auto for_each = [this](auto visit) {
    mechanisms_.ForEachMap([&](auto& map) {
      map.ForEach(
          [&](auto, auto& mounted) { visit(mounted.mechanism, *bodies_.Get(mounted.body).body); });
    });
  };
  // Crowds come first: people see the bodies before drives set new velocities.
  crowds_.ForEach([&](auto, Crowd& crowd) { crowd.BeginStep(bodies_, *layers_, dt); });
  for_each([dt](auto& mechanism, b2Body& body) { mechanism.BeginStep(body, dt); });
  const auto step = static_cast<float>(dt);
  layers_->HoldWallsNearBodies(*world_, step);
  world_->Step(step, velocity_iterations_, position_iterations_);
  while (layers_->HoldWallsOnTheWay(*world_)) {
    box2d::StepComplete(*world_) = false;
    world_->Step(step, velocity_iterations_, position_iterations_);
  }
  for_each([](auto& mechanism, b2Body& body) { mechanism.EndStep(body); });
  for (const BodyRecord* record : bodies_.Moving())
    Unwind(*record->body);  // what stays is not wound
  contacts_.EndStep(dt);
}

int World::StepUntilContact(double dt, int count) {
  return StepUntilContact(dt, count, AccessGuard(*this));
}

int World::StepUntilContact(double dt, int count, const AccessGuard& guard) {
  Require(count >= 1, "expected 1 step or more");
  const uint64_t events = contacts_.event_count();
  completed_steps_ = 0;
  while (completed_steps_ < count && contacts_.event_count() == events) {
    Step(dt, guard);
    ++completed_steps_;
  }
  return completed_steps_;
}

int World::completed_steps() const {
  RequireAccess();
  return completed_steps_;
}

}  // namespace flatland
