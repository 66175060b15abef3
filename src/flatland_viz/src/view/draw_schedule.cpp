#include "draw_schedule.hpp"

#include <algorithm>

namespace flatland_viz {
namespace {

constexpr double kShare = 0.45;      // greatest share of a core for drawing
constexpr double kRest = 1.0;        // s: period of drawing even without a noticed change
constexpr double kActionTime = 0.5;  // s: time of unlimited drawing after an action of the user
constexpr double kMemory = 0.8;      // weight of earlier frames in the smoothed cost

}  // namespace

bool DrawSchedule::IsDue(double now) const {
  const double age = now - last_drawn_;
  const double shortest = cost_ / kShare;
  if (!is_requested_) return age >= std::max(kRest, shortest);
  return age >= shortest || now - last_action_ < kActionTime;
}

void DrawSchedule::Drawn(double now, double cost) {
  is_requested_ = false;
  last_drawn_ = now;
  cost_ = kMemory * cost_ + (1.0 - kMemory) * cost;
}

}  // namespace flatland_viz
