#pragma once

/// Moves a body along a straight line as a function of time, with easing.
///
/// A tween computes the body's pose at the end of each step; EndStep places the body there. Its
/// time is kept within the present cycle, and summed with compensation of the rounding errors, so
/// that it is as exact after hours as in the first second.

#include <box2d/box2d.h>

#include <array>
#include <optional>
#include <string_view>

#include "base/geometry.hpp"
#include "motion/easing.hpp"

namespace flatland {

enum class TweenMode {
  kYoyo,     ///< to the end and back, repeatedly
  kOnce,     ///< to the end, where it stays
  kLoop,     ///< to the end, then jumps to the start, repeatedly
  kTrigger,  ///< towards the end or back to the start, as commanded by Trigger
};

/// The names of the modes in YAML, in the order of the enumeration.
extern const std::array<std::string_view, 4> kTweenModeNames;

/// The mode of this name, or nothing.
std::optional<TweenMode> FindTweenMode(std::string_view name);

struct TweenSettings {
  Pose delta;             ///< end minus start, in the world's frame [m, m, rad]
  double duration = 1.0;  ///< from the start to the end [s]
  TweenMode mode = TweenMode::kYoyo;
  Easing easing = Easing::kLinear;
};

class BodyTween {
 public:
  BodyTween() = default;
  /// A tween that begins at the pose `start` in the world [m, m, rad]. Throws std::invalid_argument
  /// if the duration is not above zero, or a number is not finite.
  BodyTween(const TweenSettings& settings, const Pose& start);

  /// Advances by a step of `dt` [s]. Returns the body's pose at its end.
  Pose Advance(double dt);
  /// Before the solver: gives the body the velocity that leads to its pose at the end of a step of
  /// `dt` [s], so that the solver lets it push others. A jump back to the start has none.
  void BeginStep(b2Body& body, double dt);
  /// After the solver: places the body at its pose exactly.
  void EndStep(b2Body& body) const;
  /// The body's present pose in the world [m, m, rad].
  Pose target() const;
  /// Elapsed fraction of the duration: 0 at the start, 1 at the end; before easing.
  double progress() const;
  /// True if the last step jumped from the end of a loop to its start.
  bool teleports() const { return teleports_; }

  /// In mode kTrigger: moves towards the end, or towards the start, as initially. Else no effect.
  void Trigger(bool forward) { forward_ = forward; }
  /// Shifts the whole movement such that the body's present pose is `pose`.
  void Rebase(const Pose& pose);

  /// Writes or reads what it keeps from step to step; see archive.hpp.
  template <class Archive>
  void Serialize(Archive& archive) {
    archive(start_, time_, time_rounding_error_, forward_);
  }

 private:
  void AddTime(double dt);
  /// Present pose minus the start.
  Pose Offset() const;

  TweenSettings settings_;
  Pose start_;
  double time_ = 0.0;  // within the cycle, which for a yoyo is two durations, else one [s]
  double time_rounding_error_ = 0.0;  // time_ minus the exact sum [s]
  bool forward_ = false;
  bool teleports_ = false;
  double dt_ = 0.0;  // of the present step [s]
};

}  // namespace flatland
