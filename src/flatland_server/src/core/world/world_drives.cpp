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
  b2RevoluteJoint* const joint = FindWheel(body, front_wheel);
  const AccessGuard guard(*this);
  return mechanisms_.tricycles.Add({body, TricycleDrive(settings, joint)});
}

World::Ackermann World::AddAckermann(Body body, const std::vector<Joint>& wheels,
                                     const AckermannSettings& settings) {
  std::array<b2RevoluteJoint*, 2> joints{};
  Require(wheels.size() <= joints.size(), "a car has two steered wheels at most");
  for (size_t i = 0; i < wheels.size(); ++i) joints[i] = FindWheel(body, wheels[i]);
  Find(body);
  const AccessGuard guard(*this);
  Require(!bodies_.Get(body).is_layer, kNotALayer);
  return mechanisms_.cars.Add({body, AckermannDrive(settings, joints)});
}

b2RevoluteJoint* World::FindWheel(Body body, Joint wheel) const {
  const b2Body& base = Find(body);
  b2Joint* const joint = joints_.Get(wheel);
  Require(joint->GetType() == e_revoluteJoint &&
              (joint->GetBodyA() == &base || joint->GetBodyB() == &base),
          "a steered wheel's joint must be a revolute joint of the driven body");
  return static_cast<b2RevoluteJoint*>(joint);
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
