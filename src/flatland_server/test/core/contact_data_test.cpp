/// The data of a contact: its fixtures, its points and normal, its impulses.

#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "flatland_server/contact.hpp"
#include "flatland_server/world.hpp"
#include "test_contact.hpp"

namespace flatland {
namespace {

TEST_F(ContactTest, NameTheWallOfALayer) {
  const World::Body layer =
      world_.AddLayer({{{-5, 9}, {5, 9}}, {{-5, -9}, {5, -9}}, {{2, -5}, {2, 5}}}, 0xFFFF);
  const World::Body box = AddBox({1.55, 0, 0});
  world_.contacts().ListenTo(layer, kBeginContact);

  world_.Step(kStep);

  ASSERT_EQ(recorder_.Story(), "b");
  const Event& event = recorder_.events[0];
  const bool layer_is_a = AreSame(event.a.body, layer);
  EXPECT_EQ((layer_is_a ? event.a : event.b).index, 2u);
  EXPECT_TRUE(AreSame((layer_is_a ? event.b : event.a).body, box));
}

TEST_F(ContactTest, NameTheFixtureOfABody) {
  const World::Body robot = AddBody({0, 0, 0});
  const Fixture left = world_.AddCircle(robot, {0, 2}, 0.5, Solid());
  const Fixture front = world_.AddCircle(robot, {2, 0}, 0.5, Solid());
  world_.AddCircle(robot, {0, -2}, 0.5, Solid());
  const World::Body other = AddBall({2.9, 0, 0});
  world_.contacts().ListenTo(other, kBeginContact);

  world_.Step(kStep);

  ASSERT_EQ(recorder_.Story(), "b");
  const Event& event = recorder_.events[0];
  const Fixture of_robot = AreSame(event.a.body, robot) ? event.a : event.b;
  EXPECT_TRUE(AreSame(of_robot.body, robot));
  EXPECT_EQ(of_robot.index, front.index);
  EXPECT_NE(of_robot.index, left.index);
}

// Along the axes and askew. Two boxes meet side to side, in two points.
TEST_F(ContactTest, HaveTheNormalFromAToB) {
  for (const double towards : {0.0, M_PI_2, M_PI, -M_PI_2, 0.7, -2.5}) {
    for (const char* shapes : {"boxes", "balls", "box and ball", "ball and box"}) {
      SCOPED_TRACE(testing::Message() << shapes << " towards " << towards);
      const bool first_is_box = std::string(shapes).substr(0, 3) == "box";
      const bool second_is_box =
          std::string(shapes).find("box", 3) != std::string::npos || std::string(shapes) == "boxes";
      const Vec2 direction{std::cos(towards), std::sin(towards)};
      const Pose there{0.99 * direction.x, 0.99 * direction.y, towards};
      const World::Body first = first_is_box ? AddBox({0, 0, towards}) : AddBall({0, 0, towards});
      const World::Body second = second_is_box ? AddBox(there) : AddBall(there);
      world_.contacts().ListenTo(first, kBeginContact);

      world_.Step(kStep);

      ASSERT_EQ(recorder_.Story(), "b");
      const Event& event = recorder_.events[0];
      const Vec2 a_to_b = AreSame(event.a.body, first) ? direction : -1.0 * direction;
      EXPECT_NEAR(event.normal.x, a_to_b.x, 1e-5);
      EXPECT_NEAR(event.normal.y, a_to_b.y, 1e-5);
      ASSERT_EQ(event.points.size(), first_is_box && second_is_box ? 2u : 1u);
      if (event.points.size() == 2) {
        const Vec2 apart = event.points[1] - event.points[0];
        EXPECT_NEAR(std::hypot(apart.x, apart.y), 1.0, kSkin);
      }
      const Vec2 left{-direction.y, direction.x};
      for (const Vec2 point : event.points) {
        EXPECT_NEAR(Dot(point, direction), 0.495, kSkin);
        EXPECT_NEAR(std::abs(Dot(point, left)), event.points.size() == 2 ? 0.5 : 0.0, kSkin);
      }
      world_.RemoveBody(first);
      world_.RemoveBody(second);
      recorder_.events.clear();
    }
  }
}

TEST_F(ContactTest, HaveTheNormalFromTheWallOrTowardsIt) {
  const World::Body layer = AddWallAt(0.0);
  for (const double side : {1.0, -1.0}) {
    const World::Body ball = AddBall({0.49 * side, 1.0, 0});
    world_.contacts().ListenTo(ball, kBeginContact);

    world_.Step(kStep);

    ASSERT_EQ(recorder_.Story(), "b");
    const Event& event = recorder_.events[0];
    const double from_layer = AreSame(event.a.body, layer) ? side : -side;
    EXPECT_NEAR(event.normal.x, from_layer, 1e-5);
    EXPECT_NEAR(event.normal.y, 0.0, 1e-5);
    ASSERT_EQ(event.points.size(), 1u);
    EXPECT_NEAR(event.points[0].x, 0.0, kSkin);
    EXPECT_NEAR(event.points[0].y, 1.0, 1e-3);
    world_.RemoveBody(ball);
    recorder_.events.clear();
  }
}

// Newton's third law: over all steps of the contact, one box gains the momentum that the other
// loses.
TEST_F(ContactTest, HaveTheImpulsesOfAHeadOnHit) {
  for (const double restitution : {0.0, 0.5}) {
    SCOPED_TRACE(restitution);
    FixtureSettings material = Solid();
    material.restitution = restitution;
    const World::Body moving = AddBox({0, 0, 0}, material);
    const World::Body waiting = AddBox({1.5, 0, 0}, material);
    world_.contacts().ListenTo(moving, kPostSolve);
    world_.SetVelocity(moving, {4, 0, 0});

    StepTimes(200);

    // Of the same mass m: m v (1 + e) / 2.
    const double expected = world_.GetMass(moving) * 4.0 * (1.0 + restitution) / 2.0;
    EXPECT_NEAR(recorder_.TotalNormalImpulse(), expected, 1e-3);
    EXPECT_NEAR(world_.GetMass(waiting) * world_.GetVelocity(waiting).vx, expected, 1e-3);
    world_.RemoveBody(moving);
    world_.RemoveBody(waiting);
    recorder_.events.clear();
  }
}

TEST_F(ContactTest, HaveTheImpulsesOfAHitAtAWall) {
  world_.contacts().ListenTo(AddWallAt(2.0), kPostSolve);
  const World::Body box = AddBox({0, 0, 0});
  world_.SetVelocity(box, {4, 0, 0});

  StepTimes(200);

  EXPECT_NEAR(recorder_.TotalNormalImpulse(), world_.GetMass(box) * 4.0, 1e-3);
  for (const Event& event : recorder_.events) {
    EXPECT_EQ(event.impulse.normal_impulses.size(), 2u);
    EXPECT_EQ(event.impulse.tangent_impulses.size(), 2u);
  }
}

// A box is pressed on a wall with 3 N, and pulled along it with 0.4 N, too weakly to slide.
TEST_F(ContactTest, HaveTheImpulsesOfPressingAndRubbing) {
  world_.contacts().ListenTo(world_.AddLayer({{{-5, 0}, {5, 0}}}, 0xFFFF), kPostSolve | kPreSolve);
  FixtureSettings rough = Solid();
  rough.friction = 1.0;
  const World::Body box = AddBox({0, 0.51, 0}, rough);

  for (int step = 0; step < 400; ++step) {
    world_.ApplyForce(box, {0.4, -3.0});
    world_.Step(kStep);
  }

  const Event& last = recorder_.events.back();
  ASSERT_EQ(last.type, kPostSolve);
  EXPECT_NEAR(Sum(last.impulse.normal_impulses), 3.0 * kStep, 1e-4 * kStep);
  EXPECT_NEAR(std::abs(Sum(last.impulse.tangent_impulses)), 0.4 * kStep, 1e-4 * kStep);
}

TEST_F(ContactTest, KnowTheirPointsAndImpulsesOfTheStepBefore) {
  const World::Body box = AddBox({0, 0, 0});
  world_.contacts().ListenTo(AddWallAt(0.51), kPreSolve | kPostSolve);
  for (int step = 0; step < 100; ++step) {
    world_.ApplyForce(box, {3.0, 0.0});
    world_.Step(kStep);
  }

  ASSERT_EQ(recorder_.events[0].type, kPreSolve);
  EXPECT_TRUE(recorder_.events[0].old_manifold.local_points.empty());
  const size_t count = recorder_.events.size();
  const Event &before = recorder_.events[count - 3], &pre = recorder_.events[count - 2];
  ASSERT_EQ(before.type, kPostSolve);
  ASSERT_EQ(pre.type, kPreSolve);
  ASSERT_EQ(pre.old_manifold.local_points.size(), 2u);
  EXPECT_EQ(pre.old_manifold.normal_impulses, before.impulse.normal_impulses);
  EXPECT_EQ(pre.old_manifold.tangent_impulses, before.impulse.tangent_impulses);
  for (const Vec2 point : pre.old_manifold.local_points) {
    EXPECT_NEAR(std::abs(point.x), 0.5, kSkin);
  }
}

}  // namespace
}  // namespace flatland
