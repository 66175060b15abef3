/// Changes of a contact by a listener: whether it is enabled, its friction, restitution and
/// tangent speed.

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <stdexcept>
#include <string>

#include "flatland_server/contact.hpp"
#include "flatland_server/world.hpp"
#include "test_contact.hpp"

namespace flatland {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
constexpr double kInfinity = std::numeric_limits<double>::infinity();

TEST_F(ContactTest, DisabledInPreSolveLetABodyPass) {
  for (const char* obstacle : {"a box", "a wall"}) {
    SCOPED_TRACE(obstacle);
    const bool is_box = std::string(obstacle) == "a box";
    const double y = is_box ? 0.0 : 20.0;
    const World::Body waiting =
        is_box ? AddBox({2, y, 0}) : world_.AddLayer({{{2, y - 5}, {2, y + 5}}}, 0xFFFF);
    const World::Body thrown = AddBox({0, y, 0});
    const World::Body driven = AddBox({-3, y, 0});
    world_.contacts().ListenTo(waiting, kAllContactEvents);
    world_.SetVelocity(thrown, {2, 0, 0});
    world_.Get(world_.AddDrive(driven, {}, {})).Command({2, 0, 0});
    recorder_.action = [](Contact& contact) {
      if (contact.event != kPreSolve) return;
      EXPECT_TRUE(contact.is_enabled());
      contact.SetEnabled(false);
      EXPECT_FALSE(contact.is_enabled());
    };

    StepTimes(800);

    EXPECT_NEAR(world_.GetPose(thrown).x, 8.0, 1e-4);
    EXPECT_NEAR(world_.GetPose(driven).x, 5.0, 1e-4);
    EXPECT_NEAR(world_.GetVelocity(thrown).vx, 2.0, 1e-6);
    EXPECT_EQ(world_.GetPose(waiting).x, is_box ? 2.0 : 0.0);
    EXPECT_EQ(recorder_.Count(kBeginContact), 2);
    EXPECT_EQ(recorder_.Count(kEndContact), 2);
    EXPECT_EQ(recorder_.Count(kPostSolve), 0);
    recorder_.events.clear();
  }
}

TEST_F(ContactTest, DisabledAreEnabledAgainInTheNextStep) {
  const World::Body waiting = AddBox({1.02, 0, 0});
  const World::Body moving = AddBox({0, 0, 0});
  world_.contacts().ListenTo(waiting, kPreSolve);
  world_.SetVelocity(moving, {2, 0, 0});
  recorder_.action = [&](Contact& contact) {
    if (recorder_.Count(kPreSolve) <= 5) contact.SetEnabled(false);
  };

  StepTimes(100);

  EXPECT_GT(world_.GetVelocity(waiting).vx, 0.9);
}

TEST_F(ContactTest, HaveARestitutionOfTheirOwn) {
  AddWallAt(2.0);
  const World::Body ball = AddBall({0, 0, 0});
  world_.contacts().ListenTo(ball, kPreSolve);
  world_.SetVelocity(ball, {3, 0, 0});
  recorder_.action = [](Contact& contact) {
    EXPECT_EQ(contact.friction(), 0.0);
    contact.SetRestitution(0.5);
    EXPECT_EQ(contact.restitution(), 0.5);
  };

  StepTimes(400);

  EXPECT_NEAR(world_.GetVelocity(ball).vx, -1.5, 1e-3);
}

// A box lies on a conveyor belt that runs at 0.3 m/s to the right.
TEST_F(ContactTest, CarryABodyAlongAMovingSurface) {
  const World::Body belt = world_.AddLayer({{{-9, 0}, {9, 0}}}, 0xFFFF);
  const World::Body box = AddBox({0, 0.51, 0});
  world_.contacts().ListenTo(belt, kPreSolve);
  recorder_.action = [&](Contact& contact) {
    contact.SetFriction(1.0);
    contact.SetTangentSpeed(AreSame(contact.a.body, belt) ? 0.3 : -0.3);
    EXPECT_NEAR(std::abs(contact.tangent_speed()), 0.3, 1e-6);
    EXPECT_EQ(contact.friction(), 1.0);
  };

  for (int step = 0; step < 400; ++step) {
    world_.ApplyForce(box, {0, -5});
    world_.Step(kStep);
  }

  EXPECT_NEAR(std::abs(world_.GetVelocity(box).vx), 0.3, 0.01);
}

TEST_F(ContactTest, RefuseValuesThatAreNotFiniteOrNegative) {
  AddBox({0, 0, 0});
  world_.contacts().ListenTo(AddBox({0.9, 0, 0}), kBeginContact);
  recorder_.action = [](Contact& contact) {
    for (const double bad : {-0.1, kNaN, kInfinity}) {
      EXPECT_THROW(contact.SetFriction(bad), std::invalid_argument) << bad;
      EXPECT_THROW(contact.SetRestitution(bad), std::invalid_argument) << bad;
    }
    EXPECT_THROW(contact.SetTangentSpeed(kNaN), std::invalid_argument);
    EXPECT_THROW(contact.SetTangentSpeed(-kInfinity), std::invalid_argument);
  };

  StepTimes(10);

  EXPECT_EQ(recorder_.Story(), "b");
}

}  // namespace
}  // namespace flatland
