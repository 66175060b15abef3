#pragma once

/// A world, and scans from any pose in it.

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "test_bodies.hpp"
#include "world/world.hpp"

namespace flatland {

struct View {
  std::vector<float> ranges;
  std::vector<float> intensities;
};

class LidarTest : public WorldTest {
 protected:
  LidarTest() { settings_.range = 30.0; }

  View Look(const BeamFan& fan, const Pose& pose) {
    View view{std::vector<float>(fan.size(), -1.0f), std::vector<float>(fan.size(), -1.0f)};
    world_.lidars().Scan(fan, pose, settings_, view.ranges.data(), view.intensities.data());
    return view;
  }

  // The range of a single beam along the lidar's x axis.
  float LookAhead(const Pose& pose) { return Look(BeamFan(0.0, 0.0, 1), pose).ranges[0]; }

  World::Body AddBody(const Pose& pose) { return world_.AddBody(At(pose)); }

  void AddWallAt(double x, LayerBits layers = 0xFFFF) {
    world_.AddLayer({{{x, -20}, {x, 20}}}, layers);
  }

  ScanSettings settings_;
  const std::vector<Vec2> square_ = Square(1.0);
  const BeamFan forward_{-0.75 * M_PI, 1.5 * M_PI / 1080, 1081};
};

}  // namespace flatland
