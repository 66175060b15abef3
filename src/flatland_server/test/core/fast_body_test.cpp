/// Bodies that move or turn by more in a step than Box2D lets them.

#include <gtest/gtest.h>

#include "test_bodies.hpp"

namespace flatland {
namespace {

class FastBody : public WorldTest {
 protected:
  World::Body body_ = AddBox(world_, {}, 0.5);
};

// 2.5 m in a step, from the first one on, with and without a ramp, and with a limited force.
TEST_F(FastBody, IsDrivenAtItsSpeed) {
  world_.Get(world_.AddDrive(body_, {}, {})).Command({25.0, 0.0, 0.0});
  for (int i = 0; i < 10; ++i) world_.Step(0.1);
  EXPECT_NEAR(world_.GetPose(body_).x, 25.0, 1e-4);
  EXPECT_NEAR(world_.GetLocalVelocity(body_).vx, 25.0, 1e-5);
}

TEST_F(FastBody, IsDrivenAtItsSpeedAsACar) {
  AckermannSettings settings;
  settings.wheelbase = 1.0;
  settings.max_steer_angle = 0.5;
  world_.Get(world_.AddAckermann(body_, {}, settings)).Command({25.0});
  for (int i = 0; i < 10; ++i) world_.Step(0.1);
  EXPECT_NEAR(world_.GetPose(body_).x, 25.0, 1e-4);
}

TEST_F(FastBody, SpeedsUpWithinASlowStep) {
  world_.Get(world_.AddDrive(body_, {50.0, 50.0, 25.0}, {})).Command({100.0, 0.0, 0.0});
  world_.Step(1.0);
  EXPECT_NEAR(world_.GetPose(body_).x, 25.0 - 0.5 * 25.0 * 0.5, 1e-4);
}

TEST_F(FastBody, TurnsAtItsRate) {
  world_.Get(world_.AddDrive(body_, {}, {})).Command({1.0, 0.0, 30.0});
  for (int i = 0; i < 10; ++i) world_.Step(0.1);
  EXPECT_NEAR(std::remainder(world_.GetPose(body_).yaw - 30.0, 2.0 * M_PI), 0.0, 1e-4);
  EXPECT_NEAR(world_.GetPose(body_).x, std::sin(30.0) / 30.0, 1e-4);
}

TEST_F(FastBody, FliesFreelyAtItsSpeedAndFeelsAForceForTheWholeStep) {
  world_.SetVelocity(body_, {0.0, 45.0, 0.0});
  const double mass = world_.GetMass(body_);
  world_.ApplyForce(body_, {mass * 2.0, 0.0});
  world_.Step(0.1);
  world_.Step(0.1);
  EXPECT_NEAR(world_.GetPose(body_).y, 9.0, 1e-4);
  EXPECT_NEAR(world_.GetVelocity(body_).vx, 0.2, 1e-6);
}

TEST_F(FastBody, IsMeasuredWhole) {
  world_.Get(world_.AddDrive(body_, {}, {})).Command({30.0, 0.0, 0.0});
  const World::Drift drift = world_.AddDrift(body_, {}, 0.3, 1);
  for (int i = 0; i < 7; ++i) world_.Step(0.1);
  EXPECT_NEAR(world_.GetEstimate(drift).x, 21.0, 1e-4);
  EXPECT_NEAR(world_.Get(drift).MeasuredVelocity().vx, 30.0, 1e-4);
}

TEST_F(FastBody, HitsAWall) {
  world_.AddLayer({{{20.0, -5.0}, {20.0, 5.0}}}, kAllLayers);
  world_.Get(world_.AddDrive(body_, {}, {})).Command({45.0, 0.0, 0.0});
  for (int i = 0; i < 10; ++i) world_.Step(0.1);
  EXPECT_NEAR(world_.GetPose(body_).x, 19.75, 0.03);
}

// The number of parts is limited, so that no step takes forever.
TEST_F(FastBody, IsHeldBackAtLast) {
  world_.SetVelocity(body_, {1e8, 0.0, 0.0});
  world_.Step(0.1);
  EXPECT_NEAR(world_.GetPose(body_).x, 2.0 * World::kMostParts, 1e-2);
}

// 100 km from the origin, a step of 1 m/s is rounded by up to 3 mm, and the next one makes up for
// it.
TEST_F(FastBody, LeavesItsRoundingBehindWhenItIsMoved) {
  for (const double away : {1e4, 9e4}) {
    const World::Drive drive = world_.AddDrive(body_, {}, {});
    world_.SetPose(body_, {away, 0.0, 0.0});
    world_.Get(drive).Command({0.9, 0.0, 0.0});
    StepTimes(world_, 3);
    world_.SetPose(body_, {});
    StepTimes(world_, 1);
    EXPECT_NEAR(world_.GetPose(body_).x, 0.9 * kStep, 1e-9);
    world_.RemoveBody(body_);
    body_ = AddBox(world_, {}, 0.5);
  }
}

// A footprint without density has the mass of 1 kg that Box2D gives.
TEST_F(FastBody, WithoutDensityIsStoppedByWallsAndPushed) {
  FixtureSettings massless;
  for (const bool is_circle : {true, false}) {
    World world{10, 10};
    world.AddLayer({{{1.0, -5.0}, {1.0, 5.0}}}, kAllLayers);
    const World::Body body = world.AddBody({});
    if (is_circle) {
      world.AddCircle(body, {}, 0.25, massless);
    } else {
      world.AddPolygon(body, Square(0.5), massless);
    }
    EXPECT_EQ(world.GetMass(body), 1.0);
    world.Get(world.AddDrive(body, {}, {})).Command({1.0, 0.0, 0.1});
    StepTimes(world, 400);
    EXPECT_NEAR(world.GetPose(body).x, 0.75, 0.1);
  }
}

}  // namespace
}  // namespace flatland
