/// Joints: their angles, limits and springs, and rotations for a very long time.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "test_bodies.hpp"
#include "world/world.hpp"

namespace flatland {
namespace {

TEST_F(WorldTest, SoftWeldYields) {
  const World::Body post = AddPost(world_, {0, 0, 0});
  const World::Body arm = AddBox(world_, {0, 0, 0});
  WeldSettings settings;
  settings.frequency = 1.0;
  settings.damping = 1.0;
  const World::Joint weld = world_.AddWeld(post, arm, settings);

  for (int step = 0; step < 1000; ++step) {
    world_.ApplyTorque(arm, 1.0);
    world_.Step(kStep);
  }
  // A spring of stiffness I (2 pi f)^2, with I = 1/6 kg m^2 for a square of 1 m and 1 kg.
  EXPECT_NEAR(world_.GetJointAngle(weld), 6.0 / (4.0 * M_PI * M_PI), 0.01);

  StepTimes(world_, 1000);
  EXPECT_NEAR(world_.GetJointAngle(weld), 0.0, 0.01);
}

TEST_F(WorldTest, JointAngleIsThatOfBMinusThatOfA) {
  const World::Body a = AddBox(world_, {0, 0, 3.0});
  const World::Body b = AddBox(world_, {0, 0, -3.0});

  EXPECT_NEAR(world_.GetJointAngle(world_.AddRevolute(a, b, {})), 2.0 * M_PI - 6.0, 1e-6);
  EXPECT_NEAR(world_.GetJointAngle(world_.AddRevolute(b, a, {})), 6.0 - 2.0 * M_PI, 1e-6);
  WeldSettings weld;
  weld.angle = 0.2;
  EXPECT_NEAR(world_.GetJointAngle(world_.AddWeld(a, b, weld)), 2.0 * M_PI - 6.2, 1e-6);
}

TEST_F(WorldTest, LimitsOfASpunHingeDoNotTurnItBack) {
  const World::Body base = AddBox(world_, {0, 0, 0}, 0.1), wheel = AddBox(world_, {0, 0, 0}, 0.2);
  const World::Body flag = AddBox(world_, {0.3, 0, 0}, 0.1);
  const World::Joint hinge = world_.AddRevolute(base, wheel, {});
  const World::Joint on_wheel = world_.AddWeld(wheel, flag, WeldAt({0.3, 0.0}));
  const auto excess = [&] {
    return world_.GetPose(wheel).yaw - world_.GetPose(base).yaw - world_.GetJointAngle(hinge);
  };
  for (const double spin : {4.0, -4.0}) {
    world_.SetMotor(hinge, JointMotor{spin, 1e3});
    for (int step = 0; step < 2000 && std::abs(excess()) < 6.0; ++step) world_.Step(kStep);
    ASSERT_GT(std::abs(excess()), 6.0) << "the bodies' angles differ by a whole rotation";
    const double angle = world_.GetJointAngle(hinge);
    world_.SetMotor(hinge, std::nullopt);
    for (const World::Body body : {base, wheel, flag}) world_.Halt(body);

    for (const double middle : {0.0, 3.0, -3.0}) {
      const double near = middle + AngleBetween(middle, angle);
      world_.SetLimits(hinge, JointLimits(std::min(near, middle), std::max(near, middle)));
      for (int step = 0; step < 50; ++step) {
        world_.Step(kStep);
        ASSERT_NEAR(AngleBetween(angle, world_.GetJointAngle(hinge)), 0.0, 1e-3);
        ASSERT_NEAR(world_.GetJointAngle(on_wheel), 0.0, 1e-3);
      }
      world_.SetLimits(hinge, std::nullopt);
    }
  }
}

// In single precision the rounding error of 3000 rad is a hundredth of the rotation of a step.
constexpr int kLongSpin = 200000;
constexpr double kSpin = 3.0;

TEST_F(WorldTest, SpinsOnFreelyAndUponAHingeForAVeryLongTime) {
  const World::Body body = AddBox(world_, {1, 2, 0}), wheel = AddBox(world_, {0, 0, 0}, 0.2);
  world_.AddRevolute(AddPost(world_, {0, 0, 0}), wheel, {});
  for (const World::Body each : {body, wheel}) world_.SetVelocity(each, {0, 0, kSpin});

  for (int step = 0; step < kLongSpin; ++step) {
    const double before = world_.GetPose(body).yaw, of_wheel = world_.GetPose(wheel).yaw;
    world_.Step(kStep);
    const double turn = AngleBetween(before, world_.GetPose(body).yaw);
    ASSERT_NEAR(turn, kSpin * kStep, 2e-6) << "step " << step;
    ASSERT_NEAR(AngleBetween(of_wheel, world_.GetPose(wheel).yaw), kSpin * kStep, 2e-6) << step;
  }
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

TEST_F(WorldTest, SpinsOnWithAHingedArmWithinItsLimits) {
  const World::Body base = AddBox(world_, {0, 0, 0}, 0.4);
  const World::Body arm = AddBox(world_, {0, 0, 0.1}, 0.1);
  const World::Joint hinge = world_.AddRevolute(base, arm, HingeWithin(-0.2, 0.2));
  world_.SetVelocity(base, {0, 0, kSpin});
  world_.SetVelocity(arm, {0, 0, kSpin});

  for (int step = 0; step < 20000; ++step) {
    world_.Step(kStep);
    ASSERT_NEAR(world_.GetJointAngle(hinge), 0.1, 0.001) << "step " << step;
  }
}

}  // namespace
}  // namespace flatland
