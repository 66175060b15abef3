#pragma once

/// What drives of all kinds have: actuators, or none, and the motion of their body.

#include <optional>

#include "motion/actuator.hpp"
#include "motion/arc_motion.hpp"

namespace flatland {

class ActuatedDrive {
 public:
  OptionalActuator& actuator() { return actuator_; }
  /// To be called when the body was moved.
  void Rebase() { motion_.Rebase(); }
  /// Seeds the noise of the actuators anew.
  void Seed(uint64_t key) {
    if (actuator_) actuator_->Seed(key);
  }
  /// Must be called when `other` replaces a joint, or when a joint is destroyed (`other` is null).
  void Replace(const b2Joint* joint, b2Joint* other) {
    if (actuator_) actuator_->Replace(joint, other);
  }

 protected:
  ActuatedDrive() = default;
  ActuatedDrive(const std::optional<ActuatorSettings>& settings, bool is_steered) {
    if (settings) actuator_ = OptionalActuator(Actuator(*settings, is_steered));
  }
  /// Begins a step of `dt` [s] with the mean twist of the body.
  void Begin(b2Body& body, const Twist& mean, double dt) {
    if (actuator_) actuator_->Roll(mean);
    motion_.Begin(body, mean, dt, actuator_.grip());
  }
  void Stop() {
    motion_ = {};
    if (actuator_) actuator_->Reset();
  }

  ArcMotion motion_;
  OptionalActuator actuator_;
};

}  // namespace flatland
