#include "draw_schedule.hpp"

#include <algorithm>

namespace flatland_viz {
namespace {

constexpr double kShare = 0.45;      // of a core that drawing may take
constexpr double kRest = 1.0;        // s: a view is drawn that often even if no change was noticed
constexpr double kActionTime = 0.5;  // s: how long an action of the user lets it draw without limit
constexpr double kLongest = 0.2;     // s: of a frame; the first one compiles shaders
constexpr double kMemory = 0.8;      // weight of earlier frames in the smoothed cost

}  // namespace

bool DrawSchedule::IsDue(double now) const {
  const double age = now - last_drawn_;
  if (age >= kRest) return true;
  if (!is_requested_) return false;
  return now - last_action_ < kActionTime || age >= cost_ / kShare;
}

void DrawSchedule::Drawn(double now, double cost) {
  is_requested_ = false;
  last_drawn_ = now;
  cost_ = kMemory * cost_ + (1.0 - kMemory) * std::min(cost, kLongest);
}

}  // namespace flatland_viz
