#pragma once

/// Drives a body at a commanded velocity, within limits of velocity and acceleration.

#include <box2d/box2d.h>

#include <optional>

#include "base/geometry.hpp"
#include "motion/actuated_drive.hpp"
#include "motion/dynamics_limits.hpp"

namespace flatland {

/// The drive of one body. Velocities are those of the body's origin, in the body's frame
/// [m/s, m/s, rad/s].
class BodyDrive : public ActuatedDrive {
 public:
  BodyDrive() = default;
  /// `linear` limits the length of the planar velocity [m/s, m/s^2], `angular` the yaw rate
  /// [rad/s, rad/s^2]. Throws std::invalid_argument if a limit is negative or not finite, or a
  /// setting of the actuators is wrong.
  BodyDrive(const DynamicsLimits& linear, const DynamicsLimits& angular,
            const std::optional<ActuatorSettings>& actuator = std::nullopt);

  /// Sets the velocity to reach. Throws std::invalid_argument if it is not finite.
  void Command(const Twist& target);
  /// The velocity to reach.
  const Twist& target() const { return target_; }
  /// The present velocity, on its way to the target.
  const Twist& velocity() const { return actuator_ ? actuator_->velocity() : velocity_; }
  /// The greatest speed and yaw rate that it may have in the next step.
  Fastest GetFastest() const;
  /// Sets the velocity and the target to zero at once.
  void Reset();

  /// Sets the body's velocity for the next step of `dt` [s].
  void BeginStep(b2Body& body, double dt);
  /// Sets the body's velocity after the step.
  void EndStep(b2Body& body);

  /// Writes or reads what it keeps from step to step; see archive.hpp.
  template <class Archive>
  void Serialize(Archive& archive) {
    archive(target_, velocity_, motion_, actuator_);
  }
  /// Calls `visit` with each member that steps change and that can be copied byte by byte.
  template <class Visit>
  void ForEachPart(Visit visit) {
    visit(target_, velocity_, motion_);
    if (actuator_) actuator_->ForEachPart(visit);
  }
  /// Calls `visit` with each setting.
  template <class Visit>
  void ForEachSetting(Visit visit) {
    linear_.ForEachSetting(visit);
    angular_.ForEachSetting(visit);
    if (actuator_) actuator_->ForEachSetting(visit);
  }

 private:
  DynamicsLimits linear_;
  DynamicsLimits angular_;
  Twist target_;
  Twist velocity_;        // within the limits
  bool is_idle_ = false;  // the body sleeps and is not to move: this step is skipped
};

}  // namespace flatland
