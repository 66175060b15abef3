/// Joints: hinges with limits and without, and welds, rigid and soft.

#include <gtest/gtest.h>

#include <cmath>

#include "flatland_server/world.hpp"
#include "test_bodies.hpp"

namespace flatland {
namespace {

TEST_F(WorldTest, RevoluteLimitsHoldUnderTorque) {
  const World::Body post = AddPost(world_, {0, 0, 0});
  const World::Body arm = AddBox(world_, {0, 0, 0});
  RevoluteSettings settings;
  settings.limits = {{-0.5, 0.8}};
  const World::Joint hinge = world_.AddRevolute(post, arm, settings);

  for (const double torque : {3.0, -3.0}) {
    for (int step = 0; step < 600; ++step) {
      world_.ApplyTorque(arm, torque);
      world_.Step(kStep);
      ASSERT_GT(world_.GetJointAngle(hinge), -0.52);
      ASSERT_LT(world_.GetJointAngle(hinge), 0.82);
    }
    EXPECT_NEAR(world_.GetJointAngle(hinge), torque > 0 ? 0.8 : -0.5, 0.02);
  }
}

TEST_F(WorldTest, RevoluteHoldsTheAnchorsTogether) {
  const World::Body post = AddPost(world_, {1, 1, 0});
  const World::Body arm = AddBox(world_, {1, 2, 0});
  RevoluteSettings settings;
  settings.anchor_b = {0, -1};
  world_.AddRevolute(post, arm, settings);
  world_.SetVelocity(arm, {1, 0, 0});

  double turned = 0.0;
  for (int step = 0; step < 400; ++step) {
    const double before = world_.GetPose(arm).yaw;
    world_.Step(kStep);
    const Pose pose = world_.GetPose(arm);
    turned += AngleBetween(before, pose.yaw);
    const Vec2 anchor = Vec2{pose.x, pose.y} + Rotation(pose.yaw).Apply({0, -1});
    ASSERT_NEAR(anchor.x, 1.0, 0.005);
    ASSERT_NEAR(anchor.y, 1.0, 0.005);
  }
  EXPECT_LT(turned, -1.0);
}

TEST_F(WorldTest, RigidWeldHolds) {
  const World::Body a = AddBox(world_, {0, 0, 0}, 0.4);
  const World::Body b = AddBox(world_, {1, 0, 0.3}, 0.4);
  WeldSettings settings;
  settings.anchor_a = {1, 0};
  settings.angle = 0.3;
  const World::Joint weld = world_.AddWeld(a, b, settings);

  for (int step = 0; step < 400; ++step) {
    world_.ApplyForce(b, {0.2, 0.5});
    world_.ApplyTorque(b, 0.2);
    world_.Step(kStep);
    const Pose pa = world_.GetPose(a), pb = world_.GetPose(b);
    ASSERT_NEAR(world_.GetJointAngle(weld), 0.0, 0.01);
    const Vec2 apart = Rotation(pa.yaw).ApplyInverse({pb.x - pa.x, pb.y - pa.y});
    ASSERT_NEAR(apart.x, 1.0, 0.01);
    ASSERT_NEAR(apart.y, 0.0, 0.01);
  }
  EXPECT_GT(std::abs(world_.GetPose(a).yaw), 0.1);
}

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

// The arm swings about a hinge beside the post, and after half a turn over the post.
TEST_F(WorldTest, JointedBodiesCollideOnlyIfEnabled) {
  for (const bool collide : {false, true}) {
    World world(10, 10);
    const World::Body post = AddPost(world, {0, 0, 0});
    world.AddPolygon(post, Square(1), Solid());
    const World::Body arm = AddBox(world, {1.6, 0, 0}, 0.4);
    RevoluteSettings settings;
    settings.anchor_a = {0.8, 0};
    settings.anchor_b = {-0.8, 0};
    settings.collide_connected = collide;
    world.AddRevolute(post, arm, settings);
    world.SetVelocity(arm, {0, 1.6, 2});

    StepTimes(world, 314);

    const Pose pose = world.GetPose(arm);
    const bool over_the_post = std::hypot(pose.x, pose.y) < 0.2;
    EXPECT_EQ(over_the_post, !collide);
  }
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

}  // namespace
}  // namespace flatland
