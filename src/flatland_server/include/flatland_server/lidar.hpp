#pragma once

/// A lidar on a body: what it looks for, and what it has seen last.

#include <cstdint>
#include <memory>
#include <vector>

#include "flatland_server/beam_fan.hpp"
#include "flatland_server/geometry.hpp"

namespace flatland {

using LayerBits = uint16_t;

/// What a lidar looks for.
struct ScanSettings {
  double range = 0.0;                ///< farthest return [m]
  LayerBits layers = 0xFFFF;         ///< what it sees
  LayerBits reflectance_layers = 0;  ///< what returns intensity 255 instead of 0
};

struct LidarSettings {
  std::shared_ptr<const BeamFan> fan;
  Pose pose;  ///< of the lidar, in the body's frame
  ScanSettings scan;
};

struct Lidar {
  LidarSettings settings;
  // By beam: distances [m] and intensities, as World::Scan says, of the world's state `seen_at`.
  std::vector<float> ranges;
  std::vector<float> intensities;
  uint64_t seen_at = 0;
  bool is_expected = false;  // to scan soon
};

}  // namespace flatland
