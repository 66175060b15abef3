#pragma once

/// Drift: errors of odometry that accumulate, as those of slipping wheels do.

#include <box2d/box2d.h>

#include <cstdint>

#include "base/geometry.hpp"
#include "base/normal_numbers.hpp"
#include "motion/actuator.hpp"

namespace flatland {

/// Errors of the wheel geometry that the odometry assumes: standard deviations, each 0 or more. One
/// value of each is drawn for a run.
struct WheelBiases {
  double radius = 0.0;       ///< of the wheels, relative: scales distances and angles
  double track_width = 0.0;  ///< relative: scales angles
  double curvature = 0.0;    ///< of a straight path, as of wheels of unequal radius [rad/m]
};

/// Growth rates of the variances of the estimated pose; each 0 or more.
struct DriftVariances {
  double translation_per_metre = 0.0;   ///< along the direction of travel [m^2/m]
  double translation_per_radian = 0.0;  ///< along the body's x axis [m^2/rad]
  double rotation_per_metre = 0.0;      ///< [rad^2/m]
  double rotation_per_radian = 0.0;     ///< [rad^2/rad]
  Pose per_second;  ///< in the body's frame, also at rest [m^2/s, m^2/s, rad^2/s]
  WheelBiases biases{};
};

/// The odometry of wheels: the velocity that they measure, and the pose that is its integral.
///
/// The motion of a step, an arc in the body's frame, is measured with an error. The errors'
/// variances add up along the path and over time, whatever the length of the steps. The velocity is
/// the mean of the measured motion since the last update. If the body is moved between two steps,
/// the estimate moves with it, without an error.
class BodyDrift {
 public:
  BodyDrift() = default;
  /// The first estimate is `start`; updates are `period` [s] apart, or every step if that is 0.
  /// Equal keys and motions give equal errors. Throws std::invalid_argument if a variance or the
  /// period is negative or not finite. `wheels` is the actuator of a drive that may slip, and must
  /// live as long. Without it, the wheels roll with the body.
  BodyDrift(const DriftVariances& variances, double period, uint64_t key, const Pose& start,
            const Actuator* wheels = nullptr);

  /// Before a step of `dt` [s]: moves the estimate with the body, if that was moved since the last
  /// step.
  void BeginStep(const b2Body& body, double dt);
  /// After the step: adds its motion, as measured, to the estimate.
  void EndStep(const b2Body& body);
  /// The estimate if the body is at `truth` [m, m, rad]; the yaw is within [-pi, pi].
  Pose Estimate(const Pose& truth) const;
  /// The mean velocity since the last update before now, in the body's frame [m/s, m/s, rad/s].
  Twist MeasuredVelocity() const;

  /// Writes or reads what it keeps from step to step; see archive.hpp.
  template <class Archive>
  void Serialize(Archive& archive) {
    archive(estimate_, last_, numbers_, trip_, now_, updated_, due_);
  }

 private:
  /// A step's motion along its arc as the wheels measure it, in the body's frame.
  Pose Measured(const Pose& arc);

  DriftVariances variances_;
  WheelBiases biases_;  // of this run
  Pose deviations_;     // standard deviations of the errors per square root of a second
  bool drifts_at_rest_ = false;
  double period_ = 0.0;  // [ns]
  const Actuator* wheels_ = nullptr;
  Pose estimate_;
  Pose last_;  // the true pose at the estimate
  NormalNumbers numbers_;
  double dt_ = 0.0;  // of the present step [s]
  Pose trip_;        // the measured motion since the last update
  // Times since the first step, in whole nanoseconds, like the times of a plugin's updates.
  uint64_t now_ = 0;
  uint64_t updated_ = 0;
  uint64_t due_ = 0;
};

/// The distances [m] driven along a body's x and y axes, if its motion is an arc.
///
/// On an arc, the body's velocity in its own frame is constant; this is that velocity times the
/// time. (The logarithm of a planar motion; Lynch and Park, "Modern Robotics", 3.3.3.) `motion` is
/// the end in the frame of the start, turned by less than half a revolution.
Vec2 ArcOf(const Pose& motion);
/// The motion along an arc: the inverse of `ArcOf`, with the same turn.
Pose MotionAlong(const Pose& arc);

}  // namespace flatland
