/// World: drives, tweens and drifts.

#include "base/box2d_limits.hpp"
#include "base/to_box2d.hpp"
#include "world/world.hpp"

namespace flatland {
namespace {

constexpr char kNotALayer[] = "a layer cannot be moved";

}  // namespace

World::Drive World::AddDrive(Body body, const DynamicsLimits& linear,
                             const DynamicsLimits& angular,
                             const std::optional<ActuatorSettings>& actuator) {
  Find(body);
  const AccessGuard guard(*this);
  Require(!bodies_.Get(body).is_layer, kNotALayer);
  return mechanisms_.drives.Add({body, BodyDrive(linear, angular, actuator)});
}

World::Tricycle World::AddTricycle(Body body, Joint front_wheel, const TricycleSettings& settings) {
  const b2Body& base = Find(body);
  const AccessGuard guard(*this);
  b2Joint* joint = joints_.Get(front_wheel);
  Require(joint->GetType() == e_revoluteJoint &&
              (joint->GetBodyA() == &base || joint->GetBodyB() == &base),
          "the front wheel's joint must be a revolute joint of the driven body");
  return mechanisms_.tricycles.Add(
      {body, TricycleDrive(settings, static_cast<b2RevoluteJoint*>(joint))});
}

World::Tween World::AddTween(Body body, const TweenSettings& settings) {
  const Pose start = GetPose(body);
  const AccessGuard guard(*this);
  Require(!bodies_.Get(body).is_layer, kNotALayer);
  bodies_.LetMove(body);
  return mechanisms_.tweens.Add({body, BodyTween(settings, start)});
}

World::Drift World::AddDrift(Body body, const DriftVariances& variances, double period,
                             uint64_t key) {
  const Pose start = GetPose(body);
  const AccessGuard guard(*this);
  return mechanisms_.drifts.Add({body, BodyDrift(variances, period, key, start)});
}

Pose World::GetEstimate(Drift drift) const {
  const auto& [body, mechanism] = mechanisms_.drifts.Get(drift);
  return mechanism.Estimate(GetPose(body));
}

}  // namespace flatland
