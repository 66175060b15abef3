/// The layers and fixtures that a lidar sees; intensities.

#include <gtest/gtest.h>

#include <cmath>

#include "reference_walls.hpp"
#include "test_scan.hpp"
#include "world/world.hpp"

namespace flatland {
namespace {

TEST_F(LidarTest, SeesNoSensors) {
  FixtureSettings sensor;
  sensor.sensor = true;
  world_.AddPolygon(AddBody({2.5, 0, 0}), square_, sensor);

  EXPECT_EQ(LookAhead({}), kInfinity);
}

TEST_F(LidarTest, SeesWhatDoesNotCollide) {
  FixtureSettings ghost;
  ghost.collides = false;
  world_.AddPolygon(AddBody({2.5, 0, 0}), square_, ghost);

  EXPECT_EQ(LookAhead({}), 2.0f);
}

TEST_F(LidarTest, SeesOnlyItsLayers) {
  FixtureSettings high;
  high.layers = 0b01;
  world_.AddPolygon(AddBody({2.5, 0, 0}), square_, high);
  AddWallAt(5.0, 0b10);
  AddWallAt(7.0, 0b01);

  settings_.layers = 0b11;
  EXPECT_EQ(LookAhead({}), 2.0f);
  settings_.layers = 0b10;
  EXPECT_EQ(LookAhead({}), 5.0f);
  settings_.layers = 0b01;
  EXPECT_EQ(LookAhead({0, 4, 0}), 7.0f);
  settings_.layers = 0b100;
  EXPECT_EQ(LookAhead({}), kInfinity);
  settings_.layers = 0;
  EXPECT_EQ(LookAhead({}), kInfinity);
}

TEST_F(LidarTest, MeasuresTheIntensityOfTheNearestThing) {
  settings_.reflectance_layers = 0b10;
  FixtureSettings dull, bright;
  dull.layers = 0b01;
  bright.layers = 0b10;
  AddWallAt(5.0, 0b10);
  AddWallAt(-5.0, 0b01);
  world_.AddPolygon(AddBody({0, 4, 0}), square_, bright);
  world_.AddPolygon(AddBody({3, 0, 0}), square_, dull);
  const auto intensity = [&](const Pose& lidar) {
    return Look(BeamFan(0.0, 0.0, 1), lidar).intensities[0];
  };

  EXPECT_EQ(intensity({0, -4, 0}), 255.0f) << "bright wall";
  EXPECT_EQ(intensity({0, 0, M_PI}), 0.0f) << "dull wall";
  EXPECT_EQ(intensity({0, 0, M_PI / 2}), 255.0f) << "bright body";
  EXPECT_EQ(intensity({0, 0, 0}), 0.0f) << "dull body before a bright wall";
  EXPECT_EQ(intensity({0, 0, -M_PI / 2}), 0.0f) << "nothing";
}

TEST_F(LidarTest, SeesWhatReflectsOnAWallOfTheSamePlace) {
  settings_.reflectance_layers = 0b10;
  AddWallAt(5.0, 0b01);
  world_.AddLayer({{{5, -1}, {5, 1}}}, 0b10);
  const Pose at_an_angle{0.123, 0.321, 0.02};

  const View view = Look(forward_, at_an_angle);

  for (int beam = 0; beam < forward_.size(); ++beam) {
    const double angle = at_an_angle.yaw - 0.75 * M_PI + beam * 1.5 * M_PI / 1080;
    if (std::abs(angle) > 1.4) continue;
    const double y = at_an_angle.y + std::tan(angle) * (5.0 - at_an_angle.x);
    if (std::abs(std::abs(y) - 1.0) < 1e-4) continue;
    ASSERT_EQ(view.intensities[beam], std::abs(y) < 1.0 ? 255.0f : 0.0f) << "beam " << beam;
  }
}

TEST_F(LidarTest, SeesNoIntensityBeyondItsRange) {
  settings_.reflectance_layers = 0b10;
  settings_.range = 5.0;
  AddWallAt(5.0 * (1.0 + 5e-10), 0b10);

  const View view = Look(BeamFan(0.0, 0.0, 1), {});

  EXPECT_EQ(view.ranges[0], kInfinity);
  EXPECT_EQ(view.intensities[0], 0.0f);
}

TEST_F(LidarTest, SeesADullWallAtItsVeryRangeBesideWhatReflects) {
  settings_.reflectance_layers = 0b10;
  settings_.range = 5.0;
  AddWallAt(5.0, 0b01);

  EXPECT_EQ(LookAhead({}), 5.0f);
}

TEST_F(LidarTest, MeasuresTheIntensityOfWhatIsAMillimetreNearer) {
  settings_.reflectance_layers = 0b10;
  AddWallAt(5.0, 0b01);
  AddWallAt(5.001, 0b10);
  AddWallAt(-5.001, 0b01);
  AddWallAt(-5.0, 0b10);

  EXPECT_EQ(Look(BeamFan(0.0, 0.0, 1), {}).intensities[0], 0.0f);
  EXPECT_EQ(Look(BeamFan(M_PI, 0.0, 1), {}).intensities[0], 255.0f);
}

TEST_F(LidarTest, IsIndependentOfTheScanBefore) {
  AddWallAt(2.0, 0b01);
  AddWallAt(-4.0, 0b10);
  settings_.reflectance_layers = 0b10;
  LookAhead({});
  settings_.reflectance_layers = 0;

  const View view = Look(BeamFan(0.0, 0.0, 1), {0, 0, M_PI});

  EXPECT_EQ(view.ranges[0], 4.0f);
  EXPECT_EQ(view.intensities[0], 0.0f);
}

}  // namespace
}  // namespace flatland
