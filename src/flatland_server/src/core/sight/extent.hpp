#pragma once

/// For depth_buffer.cpp: whether all beams that something may cover end nearer.

#include <array>

#include "base/geometry.hpp"
#include "sight/beam_fan.hpp"
#include "sight/doubles.hpp"

namespace flatland {

/// The buffer, and the pose from which it is drawn.
struct LidarView {
  const BeamFan& fan;
  double* inverse;
  Vec2 origin;
  Rotation rotation;
};

/// The part of a scan that a circle may cover.
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

}  // namespace flatland
