#pragma once

/// Actuators: what is between the commands of a drive and its wheels.

#include <cstdint>
#include <memory>
#include <vector>

#include "base/geometry.hpp"
#include "base/normal_numbers.hpp"
#include "motion/dynamics_limits.hpp"
#include "motion/grip.hpp"
#include "motion/steering.hpp"

namespace flatland {

/// Settings of an axis: of the planar velocity, or of the yaw rate or steering angle. 0 means none.
struct AxisSettings {
  double delay = 0.0;          ///< dead time of commands, 10 at most [s]
  double time_constant = 0.0;  ///< of a first-order lag [s]
  double dead_band = 0.0;  ///< a command below it counts as 0 [m/s or rad/s]; a steering command
                           ///< that is nearer than this to the held angle is ignored [rad]
  double noise = 0.0;      ///< of the velocity: spectral density, while it moves [m^2/s, rad^2/s]
};

struct ActuatorSettings {
  AxisSettings linear;
  AxisSettings angular;
  double command_timeout = 0.0;  ///< stops after this time without a command [s]; 0: never
  uint64_t key = 0;              ///< of the noise
  ForceLimits force{};

  /// Throws std::invalid_argument if a number is negative or not finite, or a delay too long.
  void Check() const;
};

/// A dead time. Keeps the values that have not arrived yet.
class DelayLine {
 public:
  /// Adds a value at time `now` [ns], and returns the newest one that was added `delay` [ns] ago or
  /// earlier; before there is one, the value of the last Reset.
  Vec2 Pass(Vec2 value, uint64_t now, uint64_t delay);
  /// Forgets the values that have not arrived; `value` is the output from now on.
  void Reset(Vec2 value);

  template <class Archive>
  void Serialize(Archive& archive) {
    auto count = static_cast<uint32_t>(under_way_.size());
    archive(count, last_in_, out_);
    if constexpr (Archive::kIsReader) {
      if (count > archive.remaining() / sizeof(Entry)) Archive::Fail();
      under_way_.resize(count);
    }
    for (Entry& each : under_way_) archive(each.time, each.value);
  }

 private:
  struct Entry {
    uint64_t time = 0;  // at which it was put in [ns]
    Vec2 value;
  };

  std::vector<Entry> under_way_;  // changes, the oldest first
  Vec2 last_in_;
  Vec2 out_;
};

/// The change of a value in a step behind a first-order lag, y' = (u - y) / `time_constant`. Exact
/// if `input`, u, is constant, or changes at a constant rate.
VelocityChange Lag(Vec2 from, const VelocityChange& input, double time_constant, double dt);

/// The actuators of a drive. Commands are (vx, vy, omega) of a body; or (speed, 0, angle) of wheels
/// that are steered.
///
/// In this order: a timeout, the dead band, the delay; then what the drive does, the limits; then
/// the noise and the lag.
class Actuator {
 public:
  /// Throws std::invalid_argument for settings that are wrong.
  Actuator(const ActuatorSettings& settings, bool is_steered);

  /// To be called for each command: the timeout begins anew.
  void Command() { state_.commanded = state_.now; }
  /// Returns the command that reaches the motors in a step of `dt` [s]; to be called once a step.
  Twist Arrive(Twist target, double dt);
  /// Adds noise and lag to the changes of velocity that the limits permit.
  void Follow(VelocityChange& linear, VelocityChange& angular, double dt);
  /// The same for the steering angle over `time` [s]: the input has a mean, and reaches a value.
  double Steer(double mean, double reached, double time);

  /// Lets the drive push its body by a joint of limited force.
  void AddGrip(b2FrictionJoint* joint) { grip_ = Grip(settings_.force, joint); }
  /// Copies everything but the joint of another actuator.
  void Take(const Actuator& other) {
    b2FrictionJoint* const joint = grip_.joint();
    *this = other;
    grip_.Replace(grip_.joint(), joint);
  }
  /// Null if the force has no limit.
  Grip* grip() { return grip_ ? &grip_ : nullptr; }
  void Replace(const b2Joint* joint, b2Joint* other) { grip_.Replace(joint, other); }
  bool may_slip() const { return settings_.force.friction > 0.0; }
  /// Sets the mean twist of the body in this step if the wheels do not slip.
  void Roll(const Twist& mean) { state_.rolling = mean; }
  /// The motion of a step of `dt` [s] as the wheels measure it, if the body moved along `arc`.
  Pose Measured(const Pose& arc, double dt) const;

  /// The present velocity of the wheels, or their speed and the steering angle.
  const Twist& velocity() const { return state_.velocity; }
  /// Forgets delayed commands. The wheels stand still, and a steering angle stays.
  void Reset();
  /// Seeds the noise anew.
  void Seed(uint64_t key) { state_.numbers = NormalNumbers(NormalNumbers::Mixed(key)); }

  /// Calls `visit` with all that changes and can be copied byte by byte; delay lines are not.
  template <class Visit>
  void ForEachPart(Visit visit) {
    visit(state_);
    grip_.ForEachPart(visit);
  }
  /// Calls `visit` with each setting.
  template <class Visit>
  void ForEachSetting(Visit visit) {
    for (AxisSettings* axis : {&settings_.linear, &settings_.angular}) {
      visit(axis->delay, axis->time_constant, axis->dead_band, axis->noise);
    }
    visit(settings_.command_timeout);
    settings_.force.ForEachSetting(visit);
    grip_.ForEachSetting(visit);
  }
  template <class Visit>
  void ForEachLine(Visit visit) {
    visit(linear_line_);
    visit(angular_line_);
  }
  /// Writes or reads what it keeps from step to step; see archive.hpp.
  template <class Archive>
  void Serialize(Archive& archive) {
    archive(state_.now, state_.commanded, state_.held, state_.velocity, state_.rolling,
            state_.numbers, linear_line_, angular_line_, grip_);
  }

 private:
  struct State {
    uint64_t now = 0;        // since the first step [ns]
    uint64_t commanded = 0;  // time of the last command [ns]
    double held = 0.0;       // the steering angle that the dead band holds [rad]
    Twist velocity;          // of the wheels
    Twist rolling;           // the mean in this step, in the body's frame
    NormalNumbers numbers;
  };

  /// White noise of a velocity: its mean over a step.
  double Noise(const AxisSettings& axis, double dt);

  ActuatorSettings settings_;
  bool is_steered_ = false;
  State state_;
  DelayLine linear_line_;
  DelayLine angular_line_;
  Grip grip_;
};

/// The actuator of a drive, or none; then it takes no time. It is copied with the drive. Assigning
/// to an existing actuator keeps its address and its joint.
class OptionalActuator {
 public:
  OptionalActuator() = default;
  explicit OptionalActuator(Actuator actuator)
      : own_(std::make_unique<Actuator>(std::move(actuator))) {}
  OptionalActuator(const OptionalActuator& other) { *this = other; }
  OptionalActuator(OptionalActuator&&) = default;
  OptionalActuator& operator=(OptionalActuator&&) = default;
  OptionalActuator& operator=(const OptionalActuator& other) {
    if (own_ != nullptr && other.own_ != nullptr) {
      own_->Take(*other.own_);
    } else {
      own_ = other.own_ == nullptr ? nullptr : std::make_unique<Actuator>(*other.own_);
    }
    return *this;
  }

  explicit operator bool() const { return own_ != nullptr; }
  Actuator* operator->() const { return own_.get(); }
  Actuator* get() const { return own_.get(); }
  Grip* grip() const { return own_ == nullptr ? nullptr : own_->grip(); }

  template <class Archive>
  void Serialize(Archive& archive) {
    archive.Same(own_ == nullptr ? 0 : 1, "whether a drive has actuators");
    if (own_ != nullptr) archive(*own_);
  }

 private:
  std::unique_ptr<Actuator> own_;
};

/// Steers for `dt` [s] towards an angle [rad], within limits, and then as the actuator does, if
/// there is one. `steering` is what the limits allow. Returns the wheels' angle after half the
/// time.
double Steer(SteeringState& steering, double target, const DynamicsLimits& limits,
             OptionalActuator& actuator, double dt);

}  // namespace flatland
