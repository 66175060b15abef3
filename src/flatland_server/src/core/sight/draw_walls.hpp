#pragma once

/// For depth_buffer.cpp: draws walls onto the beams, eight at a time.

#include <algorithm>
#include <cmath>
#include <limits>

#include "base/geometry.hpp"
#include "sight/beam_fan.hpp"
#include "sight/doubles.hpp"

namespace flatland {

/// A wall is extended past its ends by this fraction of its length, so that two walls that share a
/// corner leave no gap.
constexpr double kEndTolerance = 1e-9;
/// A wall is seen edge-on if the directions of its ends differ by less than this, or by less than
/// this from 180 degrees [rad]: its distance would be a quotient of two rounding errors.
constexpr double kEdgeOn = 1e-14;

/// The buffer, and the pose from which it is drawn.
struct LidarView {
  const BeamFan& fan;
  double* inverse;
  Vec2 origin;
  Rotation rotation;
};

/// Walls that are drawn together.
constexpr int kBlock = 8;

/// Draws the wall from a to b, where b is counter-clockwise of a, onto a group of beams.
FLATLAND_INLINE void DrawOnGroup(const BeamFan& fan, double* inverse, int group, Vec2 a, Vec2 b,
                                 double inverse_cross) {
  const Doubles x = Load(fan.xs() + group);
  const Doubles y = Load(fan.ys() + group);
  const Doubles nearest = Load(inverse + group);
  const Doubles past_a = Fill(a.x) * y - Fill(a.y) * x;
  const Doubles before_b = x * Fill(b.y) - y * Fill(b.x);
  const Doubles across = past_a + before_b;  // cross(u, b - a)
  const Mask meets = Min(past_a, before_b) >= -kEndTolerance * across;
  Store(Max(meets ? across * Fill(inverse_cross) : Fill(0.0), nearest), inverse + group);
}

/// Draws it onto a run of beams, two groups at least. Most walls cover one group or two: a
/// mispredicted branch costs more than a group in vain.
FLATLAND_INLINE void DrawOn(const BeamFan& fan, double* inverse, BeamFan::Run run, Vec2 a, Vec2 b,
                            double inverse_cross) {
  int group = run.begin & -kGroup;
  DrawOnGroup(fan, inverse, group, a, b, inverse_cross);
  DrawOnGroup(fan, inverse, group + kGroup, a, b, inverse_cross);
  for (group += 2 * kGroup; group < run.end; group += kGroup) {
    DrawOnGroup(fan, inverse, group, a, b, inverse_cross);
  }
}

/// Draws a wall on which the lidar stands: all beams end at once, except those along the wall.
inline void DrawWallAtLidar(const BeamFan& fan, double* inverse, Vec2 along) {
  for (int rank = 0; rank < fan.size(); ++rank) {
    const double across = Cross({fan.xs()[rank], fan.ys()[rank]}, along);
    if (std::abs(across) > kEdgeOn * ManhattanNorm(along))
      inverse[rank] = std::numeric_limits<double>::infinity();
  }
}

/// The ends of four walls [m].
struct FourWalls {
  Doubles ax, ay, bx, by;
};

/// The walls of a block as seen by the lidar.
struct WallsView {
  // Ends in the lidar's frame [m], b counter-clockwise of a.
  double ax[kBlock], ay[kBlock], bx[kBlock], by[kBlock];
  // cross(a, b) [m^2], or 0 if edge-on, or NaN where there is no wall; and its inverse.
  double cross[kBlock], inverse_cross[kBlock];
  // The wedge: the buckets of the widened diamond angles of a and b (BeamFan), and whether it
  // contains the backward direction.
  int from[kBlock], to[kBlock];
  long long wraps[kBlock];
};

/// Diamond angles moved clockwise, and counter-clockwise, by the margin of BeamFan, within [-2, 2].
FLATLAND_INLINE Doubles WidenRight(const Doubles& diamond_angles) {
  const Doubles widened = diamond_angles - BeamFan::kMargin;
  return widened < -2.0 ? widened + 4.0 : widened;
}
FLATLAND_INLINE Doubles WidenLeft(const Doubles& diamond_angles) {
  const Doubles widened = diamond_angles + BeamFan::kMargin;
  return widened > 2.0 ? widened - 4.0 : widened;
}

/// Computes four walls, for the places from `lane` on.
FLATLAND_INLINE void ViewWalls(const FourWalls& four, int lane, const LidarView& view,
                               WallsView* walls) {
  const Doubles cos = Fill(view.rotation.cos), sin = Fill(view.rotation.sin);
  const Doubles world_ax = four.ax - view.origin.x;
  const Doubles world_ay = four.ay - view.origin.y;
  const Doubles world_bx = four.bx - view.origin.x;
  const Doubles world_by = four.by - view.origin.y;
  const Doubles first_x = cos * world_ax + sin * world_ay;
  const Doubles first_y = cos * world_ay - sin * world_ax;
  const Doubles second_x = cos * world_bx + sin * world_by;
  const Doubles second_y = cos * world_by - sin * world_bx;
  const Doubles cross = first_x * second_y - first_y * second_x;
  const Mask swap = cross < 0.0;
  const Doubles right_x = swap ? second_x : first_x, right_y = swap ? second_y : first_y;
  const Doubles left_x = swap ? first_x : second_x, left_y = swap ? first_y : second_y;
  const Doubles size = swap ? -cross : cross;
  const Mask is_edge_on =
      size <= kEdgeOn * ManhattanNorms(right_x, right_y) * ManhattanNorms(left_x, left_y);
  Store(right_x, walls->ax + lane);
  Store(right_y, walls->ay + lane);
  Store(left_x, walls->bx + lane);
  Store(left_y, walls->by + lane);
  Store(is_edge_on ? Fill(0.0) : size, walls->cross + lane);
  Store(1.0 / size, walls->inverse_cross + lane);
  const Doubles from = WidenRight(DiamondAngles(right_x, right_y));
  const Doubles to = WidenLeft(DiamondAngles(left_x, left_y));
  Store(ToInts((from + 2.0) * view.fan.buckets_per_unit()), walls->from + lane);
  Store(ToInts((to + 2.0) * view.fan.buckets_per_unit()), walls->to + lane);
  Store(from > to, walls->wraps + lane);
}

/// Draws the first `count` walls.
FLATLAND_INLINE void DrawWalls(const WallsView& walls, int count, const LidarView& view) {
  for (int lane = 0; lane < count; ++lane) {
    const Vec2 a{walls.ax[lane], walls.ay[lane]};
    const Vec2 b{walls.bx[lane], walls.by[lane]};
    if (walls.cross[lane] > 0.0) {
      const bool wraps = walls.wraps[lane] != 0;
      const auto runs = view.fan.BeamsIn(walls.from[lane], walls.to[lane], wraps);
      DrawOn(view.fan, view.inverse, runs[0], a, b, walls.inverse_cross[lane]);
      if (wraps) DrawOn(view.fan, view.inverse, runs[1], a, b, walls.inverse_cross[lane]);
    } else if (walls.cross[lane] == 0.0 && Dot(a, b) <= 0.0) {
      DrawWallAtLidar(view.fan, view.inverse, b - a);
    }
  }
}

/// Draws the walls with these indices, in blocks.
FLATLAND_INLINE void DrawIndexed(const uint32_t* indices, int count, const Segment* segments,
                                 const LidarView& view) {
  for (int begin = 0; begin < count; begin += kBlock) {
    WallsView walls;
    for (int lane = 0; lane < kBlock; lane += kGroup) {
      Doubles rows[kGroup];
      for (int k = 0; k < kGroup; ++k) {
        rows[k] = Load(&segments[indices[std::min(begin + lane + k, count - 1)]].a.x);
      }
      Transpose(rows);
      ViewWalls({rows[0], rows[1], rows[2], rows[3]}, lane, view, &walls);
    }
    DrawWalls(walls, std::min(kBlock, count - begin), view);
  }
}

}  // namespace flatland
