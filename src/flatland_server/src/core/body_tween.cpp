#include "flatland_server/body_tween.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace flatland {
namespace {

/// Moments closer together than this are one [s]. The exponential easings jump at their ends by a
/// thousandth of the way, and a loop by the whole of it: rounding must not decide on which side.
double Instant(double duration) { return 1e-9 * std::min(duration, 1.0); }

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
      if (time_ > duration + Instant(duration)) {
        teleports_ = true;
        time_ = std::fmod(time_, duration);
        if (time_ <= Instant(duration)) time_ += duration;  // a long step, to the end of a loop
      }
      break;
    case TweenMode::kOnce:
    case TweenMode::kTrigger:
      if (time_ < 0.0 || time_ > duration) {
        time_ = std::clamp(time_, 0.0, duration);
        time_error_ = 0.0;
      }
      break;
  }
  return target();
}

Pose BodyTween::target() const {
  const Pose way = WayMade();
  return {start_.x + way.x, start_.y + way.y, start_.yaw + way.yaw};
}

double BodyTween::progress() const {
  const double duration = settings_.duration;
  const bool returns = settings_.mode == TweenMode::kYoyo && time_ > duration;
  const double time = returns ? 2.0 * duration - time_ : time_;
  if (time <= Instant(duration)) return 0.0;
  if (time >= duration - Instant(duration)) return 1.0;
  return time / duration;
}

void BodyTween::Rebase(const Pose& pose) {
  const Pose way = WayMade();
  start_ = {pose.x - way.x, pose.y - way.y, pose.yaw - way.yaw};
}

// Kahan's summation (W. Kahan, "Further remarks on reducing truncation errors", 1965).
void BodyTween::AddTime(double dt) {
  const double rest = dt - time_error_;
  const double sum = time_ + rest;
  time_error_ = (sum - time_) - rest;
  time_ = sum;
}

Pose BodyTween::WayMade() const {
  const double part = Ease(settings_.easing, progress());
  return {part * settings_.delta.x, part * settings_.delta.y, part * settings_.delta.yaw};
}

}  // namespace flatland
