#pragma once

/// A lidar on a body: its settings, and its latest scan, which Lidars makes.

#include <cstdint>
#include <memory>
#include <vector>

#include "base/collision_layers.hpp"
#include "base/geometry.hpp"
#include "base/slot_map.hpp"
#include "sight/beam_fan.hpp"
#include "sight/seen_walls.hpp"

namespace flatland {

struct BodyRecord;

struct ScanSettings {
  double range = 0.0;                ///< largest distance that is measured [m]
  LayerBits layers = kAllLayers;     ///< sees the fixtures and walls on any of these
  LayerBits reflectance_layers = 0;  ///< what is on any of these returns intensity 255, not 0
  double range_min = 0.0;  ///< what is nearer returns -infinity (REP 117) [m]; 0 is no minimum
  std::vector<Handle<BodyRecord>> ignored{};  ///< bodies that are not seen
};

struct LidarSettings {
  std::shared_ptr<const BeamFan> fan;  ///< the directions of its beams
  Pose pose;                           ///< of the lidar, in the body's frame [m, m, rad]
  ScanSettings scan;
};

/// A lidar on a body.
struct Lidar {
  LidarSettings settings;
  // The latest scan, by beam; see Lidars::Scan.
  std::vector<float> ranges;       // [m]
  std::vector<float> intensities;  // 0 or 255; empty without reflectance layers
  uint64_t scanned_revision = 0;   // revision of the world that it shows
  SeenWalls seen;                  // in the latest scan
  bool is_expected = false;        // Lidars::Expect has been called since
};

}  // namespace flatland
