#pragma once

/// For depth_buffer.cpp: which beams a box covers, and whether all of them end nearer.

#include <array>

#include "doubles.hpp"
#include "flatland_server/beam_fan.hpp"
#include "flatland_server/geometry.hpp"
#include "flatland_server/segment_tree.hpp"

namespace flatland {

/// The buffer, and the pose from which it is drawn.
struct LidarView {
  const BeamFan& fan;
  double* inverse;
  Vec2 origin;
  Rotation rotation;
};

/// The part of a scan that a box or circle may cover.
struct Extent {
  std::array<BeamFan::Run, 2> runs;  // of the beams that may meet it
  double square_distance;            // of its nearest point [m^2]; 0 if it contains the lidar
};

/// True if all beams of a run end nearer than the distance.
FLATLAND_INLINE bool EndNearer(const double* inverse, BeamFan::Run run, double square_distance) {
  for (int group = run.begin & -kGroup; group < run.end; group += kGroup) {
    const Doubles nearest = Load(inverse + group);
    const Mask reaches = nearest * nearest * square_distance < 1.0;
    if (!Any(reaches)) continue;
    for (int k = 0; k < kGroup; ++k) {
      if (reaches[k] != 0 && group + k >= run.begin && group + k < run.end) return false;
    }
  }
  return true;
}

FLATLAND_INLINE bool IsHidden(const double* inverse, const Extent& extent) {
  if (!(extent.square_distance > 0.0)) return false;
  return EndNearer(inverse, extent.runs[0], extent.square_distance) &&
         EndNearer(inverse, extent.runs[1], extent.square_distance);
}

/// Diamond angles moved clockwise, and counter-clockwise, by the margin of BeamFan, within [-2, 2].
FLATLAND_INLINE Doubles WidenRight(const Doubles& diamond_angles) {
  const Doubles widened = diamond_angles - BeamFan::kMargin;
  return widened < -2.0 ? widened + 4.0 : widened;
}
FLATLAND_INLINE Doubles WidenLeft(const Doubles& diamond_angles) {
  const Doubles widened = diamond_angles + BeamFan::kMargin;
  return widened > 2.0 ? widened - 4.0 : widened;
}

/// The outermost corners of a box as seen from outside, to the right and to the left: indices of
/// their coordinates in {low x, low y, high x, high y}.
struct Silhouette {
  int right_x, right_y, left_x, left_y;
};
/// By the lidar's position: row 0 below the box, 1 level with it, 2 above; column 0 left of it, 1
/// level with it, 2 right.
constexpr Silhouette kSilhouettes[3][3] = {
    {{2, 1, 0, 3}, {2, 1, 0, 1}, {2, 3, 0, 1}},
    {{0, 1, 0, 3}, {0, 1, 0, 1}, {2, 3, 2, 1}},
    {{0, 1, 2, 3}, {0, 3, 2, 3}, {0, 3, 2, 1}},
};

FLATLAND_INLINE const Silhouette& SilhouetteOf(const Box& box, Vec2 origin) {
  const auto side = [](double position, double low, double high) {
    return (position >= low) + (position > high);
  };
  return kSilhouettes[side(origin.y, box.low.y, box.high.y)][side(origin.x, box.low.x, box.high.x)];
}

/// Computes what two boxes cover. A box that contains the lidar gets no runs.
FLATLAND_INLINE void ComputeExtents(const Box& first, const Box& second, const LidarView& view,
                                    Extent* extents) {
  double xs[kGroup], ys[kGroup];  // right and left corner of the first box, then of the second
  for (int k = 0; k < 2; ++k) {
    const Box& box = k == 0 ? first : second;
    extents[k].square_distance = box.SquareDistance(view.origin);
    const Silhouette& seen = SilhouetteOf(box, view.origin);
    const double edges[] = {box.low.x, box.low.y, box.high.x, box.high.y};
    xs[2 * k] = edges[seen.right_x];
    ys[2 * k] = edges[seen.right_y];
    xs[2 * k + 1] = edges[seen.left_x];
    ys[2 * k + 1] = edges[seen.left_y];
  }
  const Doubles world_x = Load(xs) - view.origin.x;
  const Doubles world_y = Load(ys) - view.origin.y;
  const Doubles x = view.rotation.cos * world_x + view.rotation.sin * world_y;
  const Doubles y = view.rotation.cos * world_y - view.rotation.sin * world_x;
  const Doubles diamond_angles = DiamondAngles(x, y);
  double rights[kGroup], lefts[kGroup];
  Store(WidenRight(diamond_angles), rights);
  Store(WidenLeft(diamond_angles), lefts);
  for (int k = 0; k < 2; ++k) {
    extents[k].runs = {};
    if (!(extents[k].square_distance > 0.0)) continue;
    extents[k].runs = view.fan.BeamsIn({rights[2 * k], lefts[2 * k + 1]});
  }
}

}  // namespace flatland
