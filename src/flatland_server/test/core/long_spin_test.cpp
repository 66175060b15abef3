/// Bodies that rotate for a very long time: rounding errors must not accumulate.

#include <gtest/gtest.h>

#include <cmath>

#include "test_bodies.hpp"
#include "world/world.hpp"

namespace flatland {
namespace {

// In single precision the rounding error of 3000 rad is a hundredth of the rotation of a step.
constexpr int kLongSpin = 200000;
constexpr double kSpin = 3.0;

void ExpectSteadyRotation(World& world, World::Body body) {
  for (int step = 0; step < kLongSpin; ++step) {
    const double before = world.GetPose(body).yaw;
    world.Step(kStep);
    ASSERT_NEAR(AngleBetween(before, world.GetPose(body).yaw), kSpin * kStep, 2e-6)
        << "step " << step;
  }
}

TEST_F(WorldTest, SpinsOnForAVeryLongTime) {
  const World::Body body = AddBox(world_, {1, 2, 0});
  world_.SetVelocity(body, {0, 0, kSpin});

  ExpectSteadyRotation(world_, body);
}

TEST_F(WorldTest, SpinsOnWithAWeldedCompanionForAVeryLongTime) {
  const World::Body body = AddBox(world_, {0, 0, 0}, 0.4);
  const World::Body companion = AddBox(world_, {0.5, 0, 0.3}, 0.1);
  WeldSettings settings;
  settings.anchor_a = {0.5, 0};
  settings.angle = 0.3;
  const World::Joint weld = world_.AddWeld(body, companion, settings);
  world_.Get(world_.AddDrive(body, {}, {})).Command({0, 0, kSpin});
  StepTimes(world_, 1000);

  for (int step = 0; step < kLongSpin; ++step) {
    const double before = world_.GetPose(body).yaw;
    world_.Step(kStep);
    const Pose pose = world_.GetPose(body), other = world_.GetPose(companion);
    ASSERT_NEAR(AngleBetween(before, pose.yaw), kSpin * kStep, 2e-5) << "step " << step;
    ASSERT_LT(std::abs(world_.GetJointAngle(weld)), 0.01) << "step " << step;
    ASSERT_NEAR(std::hypot(other.x - pose.x, other.y - pose.y), 0.5, 0.005) << "step " << step;
  }
}

TEST_F(WorldTest, SpinsOnUponAHingeForAVeryLongTime) {
  const World::Body post = AddPost(world_, {0, 0, 0});
  const World::Body wheel = AddBox(world_, {0, 0, 0}, 0.2);
  world_.AddRevolute(post, wheel, {});
  world_.SetVelocity(wheel, {0, 0, kSpin});

  ExpectSteadyRotation(world_, wheel);
}

TEST_F(WorldTest, SpinsOnWithAHingedArmWithinItsLimits) {
  const World::Body base = AddBox(world_, {0, 0, 0}, 0.4);
  const World::Body arm = AddBox(world_, {0, 0, 0.1}, 0.1);
  RevoluteSettings settings;
  settings.limits = {{-0.2, 0.2}};
  const World::Joint hinge = world_.AddRevolute(base, arm, settings);
  world_.SetVelocity(base, {0, 0, kSpin});
  world_.SetVelocity(arm, {0, 0, kSpin});

  for (int step = 0; step < 20000; ++step) {
    world_.Step(kStep);
    ASSERT_NEAR(world_.GetJointAngle(hinge), 0.1, 0.001) << "step " << step;
  }
}

}  // namespace
}  // namespace flatland
