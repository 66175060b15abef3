#pragma once

/// Drift: errors of odometry that accumulate, as those of slipping wheels do.

#include <box2d/box2d.h>

#include <cstdint>

#include "flatland_server/geometry.hpp"
#include "flatland_server/normal_numbers.hpp"

namespace flatland {

/// Growth rates of the variances of the estimated pose; each 0 or more.
struct DriftVariances {
  double translation_per_metre = 0.0;   ///< along the direction of travel [m^2/m]
  double translation_per_radian = 0.0;  ///< along the body's x axis [m^2/rad]
  double rotation_per_metre = 0.0;      ///< [rad^2/m]
  double rotation_per_radian = 0.0;     ///< [rad^2/rad]
  Pose per_second;  ///< in the body's frame, also at rest [m^2/s, m^2/s, rad^2/s]
};

/// The pose that a robot estimates by adding up the motions of its steps, each with an error.
///
/// Errors are in the body's frame, so that an error of the heading bends the path that follows.
/// Their variances add up along the path and over time, whatever the length of the steps. If the
/// body is moved between two steps, the estimate moves with it, without an error.
class BodyDrift {
 public:
  BodyDrift() = default;
  /// The first estimate is `start`. Equal keys and motions give equal errors. Throws
  /// std::invalid_argument if a variance is negative or not finite.
  BodyDrift(const DriftVariances& variances, uint64_t key, const Pose& start);

  /// Before a step of `dt` [s]: takes the estimate along if the body was moved since the last one.
  void BeginStep(const b2Body& body, double dt);
  /// After the step: adds its motion to the estimate.
  void EndStep(const b2Body& body);
  /// The estimate if the body is at `truth` [m, m, rad]; the yaw is within [-pi, pi].
  Pose Estimate(const Pose& truth) const;

  /// Writes or reads what it keeps from step to step; see archive.hpp.
  template <class Archive>
  void Serialize(Archive& archive) {
    archive(estimate_, last_, numbers_);
  }

 private:
  /// The error of a step's motion, in the body's frame.
  Pose Error(const Pose& motion);

  DriftVariances variances_;
  Pose deviations_;  // of the errors per square root of a second
  bool drifts_at_rest_ = false;
  Pose estimate_;
  Pose last_;  // the true pose at the estimate
  NormalNumbers numbers_;
  double dt_ = 0.0;  // of the present step [s]
};

/// The distances [m] driven along a body's x and y axes, if its motion is an arc.
///
/// On an arc, the body's velocity in its own frame is constant; this is that velocity times the
/// time. (The logarithm of a planar motion; Lynch and Park, "Modern Robotics", 3.3.3.) `motion` is
/// the end in the frame of the start, turned by less than half a revolution.
Vec2 ArcOf(const Pose& motion);

}  // namespace flatland
