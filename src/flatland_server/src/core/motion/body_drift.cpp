#include "motion/body_drift.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "base/box2d_limits.hpp"
#include "base/to_box2d.hpp"

namespace flatland {
namespace {

constexpr Pose kNone;

/// The motion from one true pose to another, in the frame of the first.
Pose MotionBetween(const Pose& before, const Pose& after) {
  const Vec2 way = Rotation(before.yaw).ApplyInverse({after.x - before.x, after.y - before.y});
  return Wrapped({way.x, way.y, after.yaw - before.yaw});
}

}  // namespace

BodyDrift::BodyDrift(const DriftVariances& variances, double period, uint64_t key,
                     const Pose& start, const Actuator* wheels)
    : variances_(variances),
      drifts_at_rest_(!(variances.per_second == kNone)),
      period_(period * 1e9),
      wheels_(wheels),
      estimate_(Wrapped(start)),
      last_(start),
      numbers_(NormalNumbers::Mixed(key)) {
  const auto& [x, y, yaw] = variances.per_second;
  const auto& [radius, track_width, curvature] = variances.biases;
  for (const double each : {variances.translation_per_metre, variances.translation_per_radian,
                            variances.rotation_per_metre, variances.rotation_per_radian, x, y, yaw,
                            radius, track_width, curvature}) {
    RequireNotNegative(each, "a variance must be finite and not negative");
  }
  RequireNotNegative(period, "the period of updates must be finite and not negative");
  period_ = std::min(period_, 1e18);  // of UpdateTimer, too
  deviations_ = {std::sqrt(x), std::sqrt(y), std::sqrt(yaw)};
  for (auto [deviation, bias] :
       {std::pair{radius, &biases_.radius}, std::pair{track_width, &biases_.track_width},
        std::pair{curvature, &biases_.curvature}}) {
    if (deviation > 0.0) *bias = deviation * numbers_.Draw();
  }
}

void BodyDrift::BeginStep(const b2Body& body, double dt) {
  dt_ = dt;
  if (now_ >= due_) {
    trip_ = kNone;
    updated_ = now_;
    // As UpdateTimer does.
    if (period_ > 0.0) {
      const double passed = std::floor((static_cast<double>(now_) + 0.5) / period_);
      due_ = static_cast<uint64_t>(std::nearbyint((passed + 1.0) * period_));
    }
  }
  const Pose truth = PoseOf(body);
  if (truth == last_) return;
  estimate_ = Estimate(truth);
  last_ = truth;
}

void BodyDrift::EndStep(const b2Body& body) {
  now_ += static_cast<uint64_t>(std::nearbyint(dt_ * 1e9));
  const Pose truth = PoseOf(body);
  if (truth == last_ && !drifts_at_rest_ && wheels_ == nullptr) return;
  const Pose motion = MotionBetween(last_, truth);
  const Vec2 way = ArcOf(motion);
  const Pose made{way.x, way.y, motion.yaw};
  const Pose arc = Measured(wheels_ == nullptr ? made : wheels_->Measured(made, dt_));
  trip_ = {trip_.x + arc.x, trip_.y + arc.y, trip_.yaw + arc.yaw};
  estimate_ = Wrapped(Compose(estimate_, MotionAlong(arc)));
  last_ = truth;
}

Pose BodyDrift::Estimate(const Pose& truth) const {
  if (truth == last_) return estimate_;
  return Wrapped(Compose(estimate_, MotionBetween(last_, truth)));
}

Twist BodyDrift::MeasuredVelocity() const {
  if (now_ == updated_) return {};
  const double seconds = static_cast<double>(now_ - updated_) * 1e-9;
  return {trip_.x / seconds, trip_.y / seconds, trip_.yaw / seconds};
}

Pose BodyDrift::Measured(const Pose& arc) {
  Pose measured = arc;
  if (!(arc == kNone)) {
    const double along = numbers_.Draw(), turned = numbers_.Draw(), heading = numbers_.Draw();
    const double metres = std::hypot(arc.x, arc.y), radians = std::abs(arc.yaw);
    const double slip =
        metres > 0.0 ? along * std::sqrt(variances_.translation_per_metre / metres) : 0.0;
    const double scale = 1.0 + biases_.radius;
    measured.x =
        (scale + slip) * arc.x + turned * std::sqrt(variances_.translation_per_radian * radians);
    measured.y = (scale + slip) * arc.y;
    measured.yaw = scale * (1.0 + biases_.track_width) * arc.yaw + biases_.curvature * arc.x +
                   heading * std::sqrt(variances_.rotation_per_metre * metres +
                                       variances_.rotation_per_radian * radians);
  }
  if (drifts_at_rest_) {
    const double root = std::sqrt(dt_);
    measured.x += root * deviations_.x * numbers_.Draw();
    measured.y += root * deviations_.y * numbers_.Draw();
    measured.yaw += root * deviations_.yaw * numbers_.Draw();
  }
  return measured;
}

Vec2 ArcOf(const Pose& motion) {
  const double half = motion.yaw / 2.0;
  const double cotangent = std::abs(half) > 1e-6 ? half / std::tan(half) : 1.0;
  return {cotangent * motion.x + half * motion.y, cotangent * motion.y - half * motion.x};
}

Pose MotionAlong(const Pose& arc) {
  const double half = arc.yaw / 2.0;
  // The chord is shorter than the arc, and turned by half of its angle.
  const double sinc = std::abs(half) > 1e-6 ? std::sin(half) / half : 1.0;
  const double cos = sinc * std::cos(half), sin = sinc * std::sin(half);
  return {cos * arc.x - sin * arc.y, sin * arc.x + cos * arc.y, arc.yaw};
}

}  // namespace flatland
