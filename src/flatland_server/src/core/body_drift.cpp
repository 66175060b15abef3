#include "flatland_server/body_drift.hpp"

#include <cmath>

#include "box2d_limits.hpp"
#include "to_box2d.hpp"

namespace flatland {
namespace {

constexpr Pose kNone;

/// The motion from one true pose to another, in the frame of the first.
Pose MotionBetween(const Pose& before, const Pose& after) {
  const Vec2 way = Rotation(before.yaw).ApplyInverse({after.x - before.x, after.y - before.y});
  return Wrapped({way.x, way.y, after.yaw - before.yaw});
}

}  // namespace

BodyDrift::BodyDrift(const DriftVariances& variances, uint64_t key, const Pose& start)
    : variances_(variances),
      drifts_at_rest_(!(variances.per_second == kNone)),
      estimate_(Wrapped(start)),
      last_(start),
      numbers_(NormalNumbers::Mixed(key)) {
  const auto& [x, y, yaw] = variances.per_second;
  for (const double each :
       {variances.translation_per_metre, variances.translation_per_radian,
        variances.rotation_per_metre, variances.rotation_per_radian, x, y, yaw}) {
    RequireNotNegative(each, "a variance must be finite and not negative");
  }
  deviations_ = {std::sqrt(x), std::sqrt(y), std::sqrt(yaw)};
}

void BodyDrift::BeginStep(const b2Body& body, double dt) {
  dt_ = dt;
  const Pose truth = PoseOf(body);
  if (truth == last_) return;
  estimate_ = Estimate(truth);
  last_ = truth;
}

void BodyDrift::EndStep(const b2Body& body) {
  const Pose truth = PoseOf(body);
  if (truth == last_ && !drifts_at_rest_) return;
  const Pose motion = MotionBetween(last_, truth);
  const Pose error = Error(motion);
  // Half of it before the motion and half after: to second order, this is noise that is spread over
  // the motion, and bends the path as many small steps would.
  const Pose half{0.5 * error.x, 0.5 * error.y, 0.5 * error.yaw};
  estimate_ = Wrapped(Compose(Compose(Compose(estimate_, half), motion), half));
  last_ = truth;
}

Pose BodyDrift::Estimate(const Pose& truth) const {
  if (truth == last_) return estimate_;
  return Wrapped(Compose(estimate_, MotionBetween(last_, truth)));
}

Pose BodyDrift::Error(const Pose& motion) {
  Pose error;
  if (!(motion == kNone)) {
    const double along = numbers_.Draw(), turned = numbers_.Draw(), heading = numbers_.Draw();
    const Vec2 arc = ArcOf(motion);
    const double metres = std::sqrt(Dot(arc, arc)), radians = std::abs(motion.yaw);
    // Per metre driven.
    const double slip =
        metres > 0.0 ? along * std::sqrt(variances_.translation_per_metre / metres) : 0.0;
    error.x = slip * arc.x + turned * std::sqrt(variances_.translation_per_radian * radians);
    error.y = slip * arc.y;
    error.yaw = heading * std::sqrt(variances_.rotation_per_metre * metres +
                                    variances_.rotation_per_radian * radians);
  }
  if (drifts_at_rest_) {
    const double root = std::sqrt(dt_);
    error.x += root * deviations_.x * numbers_.Draw();
    error.y += root * deviations_.y * numbers_.Draw();
    error.yaw += root * deviations_.yaw * numbers_.Draw();
  }
  return error;
}

Vec2 ArcOf(const Pose& motion) {
  const double half = motion.yaw / 2.0;
  const double cotangent = std::abs(half) > 1e-6 ? half / std::tan(half) : 1.0;
  return {cotangent * motion.x + half * motion.y, cotangent * motion.y - half * motion.x};
}

}  // namespace flatland
