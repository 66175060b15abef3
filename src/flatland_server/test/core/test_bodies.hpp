#pragma once

/// A world, bodies to put into it, and comparisons of poses and twists.

#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <vector>

#include "world/world.hpp"

namespace flatland {

inline constexpr double kStep = 0.005;  ///< [s]

inline FixtureSettings Dense(double density) {
  FixtureSettings settings;
  settings.density = density;
  return settings;
}

inline FixtureSettings Solid() { return Dense(1.0); }

inline FixtureSettings Ghost() {
  FixtureSettings settings = Solid();
  settings.collides = false;
  return settings;
}

inline FixtureSettings OnLayers(LayerBits layers) {
  FixtureSettings settings = Solid();
  settings.layers = layers;
  return settings;
}

inline FixtureSettings Sensor() {
  FixtureSettings settings = Solid();
  settings.sensor = true;
  return settings;
}

inline std::vector<Vec2> Square(double side) {
  const double h = side / 2;
  return {{-h, -h}, {h, -h}, {h, h}, {-h, h}};
}

inline BodySettings At(const Pose& pose, b2BodyType type = b2_dynamicBody) {
  BodySettings settings;
  settings.type = type;
  settings.pose = pose;
  return settings;
}

inline World::Body AddBox(World& world, const Pose& pose, double side = 1.0,
                          const FixtureSettings& fixture = Solid()) {
  const World::Body box = world.AddBody(At(pose));
  world.AddPolygon(box, Square(side), fixture);
  return box;
}

inline World::Body AddPost(World& world, const Pose& pose) {
  return world.AddBody(At(pose, b2_staticBody));
}

inline World::Body AddDisc(World& world, const Pose& pose, double radius,
                           const FixtureSettings& fixture = Solid(), Vec2 center = {}) {
  const World::Body disc = world.AddBody(At(pose));
  world.AddCircle(disc, center, radius, fixture);
  return disc;
}

inline RevoluteSettings HingeWithin(double lower, double upper) {
  RevoluteSettings settings;
  settings.limits = {{lower, upper}};
  return settings;
}

inline WeldSettings WeldAt(Vec2 anchor_a) {
  WeldSettings settings;
  settings.anchor_a = anchor_a;
  return settings;
}

inline LidarSettings LidarOf(double angle_min, double increment, int beams) {
  LidarSettings settings;
  settings.fan = std::make_shared<BeamFan>(angle_min, increment, beams);
  settings.scan.range = 5.0;
  return settings;
}

inline void StepTimes(World& world, int steps) {
  for (int step = 0; step < steps; ++step) world.Step(kStep);
}

inline double AngleBetween(double from, double to) { return std::remainder(to - from, 2.0 * M_PI); }

inline void ExpectPose(const Pose& pose, const Pose& expected, double tolerance) {
  EXPECT_NEAR(pose.x, expected.x, tolerance);
  EXPECT_NEAR(pose.y, expected.y, tolerance);
  EXPECT_NEAR(AngleBetween(expected.yaw, pose.yaw), 0.0, tolerance);
}

inline void ExpectTwist(const Twist& twist, const Twist& expected, double tolerance) {
  EXPECT_NEAR(twist.vx, expected.vx, tolerance);
  EXPECT_NEAR(twist.vy, expected.vy, tolerance);
  EXPECT_NEAR(twist.omega, expected.omega, tolerance);
}

class WorldTest : public testing::Test {
 protected:
  World world_{10, 10};
};

inline void ExpectSame(const std::vector<Pose>& a, const std::vector<Pose>& b) {
  ASSERT_EQ(a.size(), b.size());
  for (size_t i = 0; i < a.size(); ++i) ASSERT_EQ(a[i], b[i]) << i;
}

}  // namespace flatland
