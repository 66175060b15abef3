/// Construction, access and stepping. The other parts of World are in world_*.cpp, one file for
/// each group of functions in world.hpp.

#include "flatland_server/world.hpp"

#include <algorithm>
#include <stdexcept>

#include "box2d_limits.hpp"
#include "to_box2d.hpp"

namespace flatland {
namespace {

constexpr char kInUse[] = "the world is in use by another thread";
constexpr char kInListener[] =
    "during contact events nothing can be added, removed, moved or scanned; wait for the end of "
    "the step";

/// Takes whole rotations off a body's angle, and off the angles of all bodies that a joint compares
/// with it. Box2D keeps angles in single precision: after an hour of spinning, the rotation of one
/// step would be lost in rounding. A hinge without limits compares nothing.
void Unwind(b2Body& body) {
  if (!IsWound(body)) return;
  constexpr float kFullRotation = 2.0f * b2_pi;
  const float excess = std::round(body.GetAngle() / kFullRotation) * kFullRotation;
  std::vector<b2Body*> group{&body};
  for (size_t i = 0; i < group.size(); ++i) {
    b2Body& member = *group[i];
    member.SetTransform(member.GetPosition(), member.GetAngle() - excess);
    for (b2JointEdge* edge = member.GetJointList(); edge != nullptr; edge = edge->next) {
      const bool compares = edge->joint->GetType() != e_revoluteJoint ||
                            static_cast<b2RevoluteJoint*>(edge->joint)->IsLimitEnabled();
      const bool is_new = std::find(group.begin(), group.end(), edge->other) == group.end();
      if (compares && is_new) group.push_back(edge->other);
    }
  }
}

}  // namespace

World::World(int velocity_iterations, int position_iterations, std::size_t large_layer)
    : world_(std::make_unique<b2World>(b2Vec2_zero)),
      velocity_iterations_(velocity_iterations),
      position_iterations_(position_iterations),
      large_layer_(large_layer) {
  Require(velocity_iterations >= 1 && position_iterations >= 1,
          "a solver needs at least one iteration");
  world_->SetDestructionListener(this);
}

void World::BeginAccess() const {
  if (is_in_use_.exchange(true)) throw std::logic_error(IsInListener() ? kInListener : kInUse);
}

void World::RequireAccess() const {
  if (is_in_use_ && !IsInListener()) throw std::logic_error(kInUse);
}

bool World::IsInListener() const { return listener_thread_ == std::this_thread::get_id(); }

void World::Step(double dt, const AccessGuard&) {
  Require(IsUsable(dt) && dt >= kMinStep, "a step must be finite and longer than zero");
  ++revision_;
  const auto for_each = [this](auto& map, auto visit) {
    map.ForEach(
        [&](auto, auto& mounted) { visit(mounted.mechanism, *bodies_.Get(mounted.body).body); });
  };
  const auto begin = [dt](auto& drive, b2Body& body) { drive.BeginStep(body, dt); };
  const auto end = [](auto& drive, b2Body& body) { drive.EndStep(body); };
  for_each(drives_, begin);
  for_each(tricycles_, begin);
  for_each(tweens_, [&](BodyTween& tween, b2Body& body) { AdvanceTween(tween, body, dt); });
  HoldWallsNearBodies();
  world_->Step(static_cast<float>(dt), velocity_iterations_, position_iterations_);
  for_each(drives_, end);
  for_each(tricycles_, end);
  for_each(tweens_, [&](BodyTween& tween, b2Body& body) { FinishTween(tween, body, dt); });
  RefreshMovingBodies();  // what stays is not wound
  for (const BodyRecord* record : moving_) Unwind(*record->body);
  ApplyDeferredForces();
}

int World::StepUntilContact(double dt, int count, const AccessGuard& guard) {
  Require(count >= 1, "expected 1 step or more");
  has_called_listener_ = false;
  completed_steps_ = 0;
  while (completed_steps_ < count && !has_called_listener_) {
    Step(dt, guard);
    ++completed_steps_;
  }
  return completed_steps_;
}

}  // namespace flatland
