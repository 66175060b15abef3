#include "corner_scans.hpp"

#include <array>
#include <cmath>

#include "box_extents.hpp"
#include "doubles.hpp"
#include "sight_lines.hpp"

namespace flatland {
namespace {

constexpr int kBeams = 720;
/// Allowance for the rounding of a range.
constexpr double kFarther = 1.0 + 1e-6;

const BeamFan& Fan() {
  static const BeamFan fan(-M_PI, 2.0 * M_PI / kBeams, kBeams);
  return fan;
}

/// Of a wall as seen from each corner.
struct WallViews {
  double right_x[kGroup], right_y[kGroup], left_x[kGroup], left_y[kGroup];  // its ends
  double cross[kGroup];                                                     // of these two
  double from[kGroup], to[kGroup];  // its wedge, by diamond angles
};

FLATLAND_CLONES void View(const Segment& wall, const double* x, const double* y, WallViews* views) {
  const Doubles ax = wall.a.x - Load(x), ay = wall.a.y - Load(y);
  const Doubles bx = wall.b.x - Load(x), by = wall.b.y - Load(y);
  const Doubles cross = ax * by - ay * bx;
  const Mask is_a_right = cross > 0.0;
  const Doubles right_x = is_a_right ? ax : bx, right_y = is_a_right ? ay : by;
  const Doubles left_x = is_a_right ? bx : ax, left_y = is_a_right ? by : ay;
  Store(right_x, views->right_x);
  Store(right_y, views->right_y);
  Store(left_x, views->left_x);
  Store(left_y, views->left_y);
  Store(Abs(cross), views->cross);
  Store(WidenRight(DiamondAngles(right_x, right_y)), views->from);
  Store(WidenLeft(DiamondAngles(left_x, left_y)), views->to);
}

}  // namespace

CornerScans::CornerScans(const SegmentTree& walls, const Box& box) : walls_(walls) {
  const std::array<Vec2, kCount> corners = CornersOf(box);
  for (int i = 0; i < kCount; ++i) {
    x_[i] = corners[i].x;
    y_[i] = corners[i].y;
  }
}

bool CornerScans::MakeNext() {
  const size_t made = ranges_.size() / kBeams;
  if (made == kCount) return false;
  ranges_.resize((made + 1) * kBeams);
  buffer_.Begin(Fan(), 1e9);
  buffer_.Draw(walls_, {x_[made], y_[made], 0.0});
  buffer_.GetRanges(ranges_.data() + made * kBeams);
  return true;
}

bool CornerScans::See(const Segment& wall) const {
  WallViews views;
  View(wall, x_, y_, &views);
  const Vec2 along = wall.b - wall.a;
  const BeamFan& fan = Fan();
  for (int i = 0; i < kCount; ++i) {
    if (views.cross[i] == 0.0) continue;  // seen edge-on, or from an end
    const Vec2 right{views.right_x[i], views.right_y[i]}, left{views.left_x[i], views.left_y[i]};
    const float* const ranges = ranges_.data() + static_cast<ptrdiff_t>(i) * kBeams;
    for (const BeamFan::Run& run : fan.BeamsIn({views.from[i], views.to[i]})) {
      for (int k = run.begin; k < run.end; ++k) {
        const Vec2 way = fan.direction(k);
        if (Cross(way, right) > 0.0 || Cross(way, left) < 0.0) continue;
        if (views.cross[i] <= ranges[k] * kFarther * std::abs(Cross(way, along))) return true;
      }
    }
  }
  return false;
}

}  // namespace flatland
