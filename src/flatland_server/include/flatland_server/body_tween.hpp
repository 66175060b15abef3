#pragma once

/// Moves a body along a straight way by the clock, eased, at every step, without Python.
///
/// A tween says where its body is at the end of a step; whoever steps the world puts it there. Its
/// time is kept within the cycle it is in and added up with the rounding error of each sum carried
/// along, so that it is as exact after hours as in its first second.

#include <array>
#include <optional>
#include <string_view>

#include "flatland_server/easing.hpp"
#include "flatland_server/geometry.hpp"

namespace flatland {

enum class TweenMode {
  kYoyo,     ///< to the end and back the same way, again and again
  kOnce,     ///< to the end, and stays there
  kLoop,     ///< to the end, and at once from the start again
  kTrigger,  ///< towards the end or back towards the start, as it is told
};

/// Their names in YAML, in the order of the enumeration.
extern const std::array<std::string_view, 4> kTweenModeNames;

/// The mode of that name, if there is one.
std::optional<TweenMode> FindTweenMode(std::string_view name);

struct TweenSettings {
  Pose delta;             ///< end less start, in the world's frame [m, m, rad]
  double duration = 1.0;  ///< from the start to the end [s]
  TweenMode mode = TweenMode::kYoyo;
  Easing easing = Easing::kLinear;
};

class BodyTween {
 public:
  BodyTween() = default;
  /// A movement of a body that is now at `start`, in the world's frame. Throws
  /// std::invalid_argument if the duration is not above zero, or a number is not finite.
  BodyTween(const TweenSettings& settings, const Pose& start);

  /// Moves on by a step of `dt` seconds. Returns where the body is at its end.
  Pose Advance(double dt);
  /// Where the body is now.
  Pose target() const;
  /// How much of the way's time is behind the body, 0 at the start and 1 at the end; not eased.
  double progress() const;
  /// Whether the last step led over the end of a loop: back to the start without a way.
  bool teleports() const { return teleports_; }

  /// For mode trigger: towards the end, or, as at first, towards the start. Else without effect.
  void Trigger(bool forward) { forward_ = forward; }
  /// Something else has put the body there: the movement goes on from there.
  void Rebase(const Pose& pose);

 private:
  void AddTime(double dt);
  Pose WayMade() const;

  TweenSettings settings_;
  Pose start_;
  double time_ = 0.0;  // within the cycle: there and back for a yoyo, there for the others [s]
  double time_error_ = 0.0;  // what time_ is too large by, from rounding [s]
  bool forward_ = false;
  bool teleports_ = false;
};

}  // namespace flatland
