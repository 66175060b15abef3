#include "motion/body_tween.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "base/to_box2d.hpp"

namespace flatland {
namespace {

/// Times closer together than this count as equal [s]. At its ends an exponential easing jumps by a
/// thousandth of the distance, and a loop by all of it: rounding errors must not decide on which
/// side of the jump the body is.
double TimeTolerance(double duration) { return 1e-9 * std::min(duration, 1.0); }

}  // namespace

const std::array<std::string_view, 4> kTweenModeNames = {"yoyo", "once", "loop", "trigger"};

std::optional<TweenMode> FindTweenMode(std::string_view name) {
  const auto found = std::find(kTweenModeNames.begin(), kTweenModeNames.end(), name);
  if (found == kTweenModeNames.end()) return std::nullopt;
  return static_cast<TweenMode>(found - kTweenModeNames.begin());
}

BodyTween::BodyTween(const TweenSettings& settings, const Pose& start)
    : settings_(settings), start_(start) {
  if (!IsUsable(settings.delta)) throw std::invalid_argument("a tween's delta must be finite");
  if (!IsUsable(settings.duration) || settings.duration <= 0.0) {
    throw std::invalid_argument("a tween's duration must be finite and above zero");
  }
  if (!IsUsable(start)) throw std::invalid_argument("a tween's start must be finite");
}

Pose BodyTween::Advance(double dt) {
  const double duration = settings_.duration;
  const bool backwards = settings_.mode == TweenMode::kTrigger && !forward_;
  AddTime(backwards ? -dt : dt);
  teleports_ = false;
  switch (settings_.mode) {
    case TweenMode::kYoyo:
      time_ = std::fmod(time_, 2.0 * duration);  // fmod is exact
      break;
    case TweenMode::kLoop:
      if (time_ > duration + TimeTolerance(duration)) {
        teleports_ = true;
        time_ = std::fmod(time_, duration);
        if (time_ <= TimeTolerance(duration))
          time_ += duration;  // a long step that ends at the end of a loop
      }
      break;
    case TweenMode::kOnce:
    case TweenMode::kTrigger:
      if (time_ < 0.0 || time_ > duration) {
        time_ = std::clamp(time_, 0.0, duration);
        time_rounding_error_ = 0.0;
      }
      break;
  }
  return target();
}

void BodyTween::BeginStep(b2Body& body, double dt) {
  const Pose from = target();
  const Pose to = Advance(dt);
  dt_ = dt;
  const Twist velocity = teleports_
                             ? Twist{}
                             : Twist{(to.x - body.GetPosition().x) / dt,
                                     (to.y - body.GetPosition().y) / dt, (to.yaw - from.yaw) / dt};
  SetOriginVelocity(body, velocity);
}

void BodyTween::EndStep(b2Body& body) const {
  const double omega = body.GetAngularVelocity();
  const Vec2 of_center = FromBox2D(body.GetLinearVelocity());
  const Vec2 arm = Rotation(body.GetAngle() - omega * dt_).Apply(FromBox2D(body.GetLocalCenter()));
  Place(body, target());
  SetOriginVelocity(body, {of_center.x + omega * arm.y, of_center.y - omega * arm.x, omega});
  WakeBodiesNear(body);
}

Pose BodyTween::target() const {
  const Pose offset = Offset();
  return {start_.x + offset.x, start_.y + offset.y, start_.yaw + offset.yaw};
}

double BodyTween::progress() const {
  const double duration = settings_.duration;
  const bool returns = settings_.mode == TweenMode::kYoyo && time_ > duration;
  const double time = returns ? 2.0 * duration - time_ : time_;
  if (time <= TimeTolerance(duration)) return 0.0;
  if (time >= duration - TimeTolerance(duration)) return 1.0;
  return time / duration;
}

void BodyTween::Rebase(const Pose& pose) {
  const Pose offset = Offset();
  start_ = {pose.x - offset.x, pose.y - offset.y, pose.yaw - offset.yaw};
}

// Kahan's summation (W. Kahan, "Further remarks on reducing truncation errors", 1965).
void BodyTween::AddTime(double dt) {
  const double rest = dt - time_rounding_error_;
  const double sum = time_ + rest;
  time_rounding_error_ = (sum - time_) - rest;
  time_ = sum;
}

Pose BodyTween::Offset() const {
  const double part = Ease(settings_.easing, progress());
  return {part * settings_.delta.x, part * settings_.delta.y, part * settings_.delta.yaw};
}

}  // namespace flatland
