/// Mass, forces and impulses.

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <utility>

#include "test_bodies.hpp"
#include "world/world.hpp"

namespace flatland {
namespace {

TEST_F(WorldTest, VelocityIsThatOfTheOrigin) {
  const World::Body body = AddDisc(world_, {1, 1, M_PI / 2}, 0.2, Solid(), {0.3, 0});

  world_.SetVelocity(body, {1, 0, 2});

  ExpectTwist(world_.GetVelocity(body), {1, 0, 2}, 1e-6);
  ExpectTwist(world_.GetLocalVelocity(body), {0, -1, 2}, 1e-6);
}

// A body with its centre of mass at (0.3, 0.1) in its frame: 2 m by 1 m, 2 kg/m^2, so 4 kg.
World::Body AddPlank(World& world, const Pose& pose) {
  const World::Body plank = world.AddBody(At(pose));
  world.AddPolygon(plank, {{-0.7, -0.4}, {1.3, -0.4}, {1.3, 0.6}, {-0.7, 0.6}}, Dense(2.0));
  return plank;
}

constexpr double kPlankInertia = 4.0 * (2.0 * 2.0 + 1.0 * 1.0) / 12.0;  // m (a^2 + b^2) / 12

void ExpectPoint(Vec2 point, Vec2 expected, double tolerance) {
  EXPECT_NEAR(point.x, expected.x, tolerance);
  EXPECT_NEAR(point.y, expected.y, tolerance);
}

TEST_F(WorldTest, MassAndInertiaAreAboutTheCentreOfMass) {
  const World::Body plank = AddPlank(world_, {5, 6, M_PI / 2});

  EXPECT_NEAR(world_.GetMass(plank), 4.0, 1e-5);
  EXPECT_NEAR(world_.GetInertia(plank), kPlankInertia, 1e-5);
  ExpectPoint(world_.GetCenter(plank), {5 - 0.1, 6 + 0.3}, 1e-5);
}

TEST_F(WorldTest, WhatIsNotDynamicHasNoMass) {
  for (const b2BodyType type : {b2_staticBody, b2_kinematicBody}) {
    const World::Body body = world_.AddBody(At({1, 2, 0}, type));
    world_.AddCircle(body, {0.3, 0}, 1.0, Solid());

    EXPECT_EQ(world_.GetType(body), type);
    EXPECT_EQ(world_.GetMass(body), 0.0);
    EXPECT_EQ(world_.GetInertia(body), 0.0);
  }
}

TEST_F(WorldTest, ForceAtAPointRotatesByItsArm) {
  for (const bool is_at_centre : {true, false}) {
    const World::Body plank = AddPlank(world_, {5, 6, 0.4});
    const Vec2 center = world_.GetCenter(plank), point{7, 5.5}, force{8, -4};

    if (is_at_centre) world_.ApplyForce(plank, force);
    if (!is_at_centre) world_.ApplyForce(plank, force, point);
    world_.Step(0.01);

    const double torque = is_at_centre ? 0.0 : Cross(point - center, force);
    EXPECT_NEAR(world_.GetVelocity(plank).omega, 0.01 * torque / kPlankInertia, 1e-6);
    ExpectPoint(world_.GetVelocityAt(plank, world_.GetCenter(plank)), {0.02, -0.01}, 1e-6);
    world_.RemoveBody(plank);
  }
}

TEST_F(WorldTest, ForcesLastForOneStep) {
  const World::Body plank = AddPlank(world_, {5, 6, 0.4});
  world_.ApplyForce(plank, {4, 0});
  world_.ApplyForce(plank, {4, -4});
  world_.ApplyTorque(plank, -3.0);  // about the centre

  StepTimes(world_, 10);

  EXPECT_NEAR(world_.GetVelocity(plank).omega, -3.0 * kStep / kPlankInertia, 1e-6);
  ExpectPoint(world_.GetVelocityAt(plank, world_.GetCenter(plank)), {kStep * 8 / 4, -kStep * 4 / 4},
              1e-6);
}

TEST_F(WorldTest, ImpulsesCountAtOnce) {
  const World::Body plank = AddPlank(world_, {5, 6, 0.4});
  const Vec2 center = world_.GetCenter(plank), point{4, 7}, impulse{1, -2};

  world_.ApplyLinearImpulse(plank, impulse);
  ExpectPoint(world_.GetVelocityAt(plank, center), {0.25, -0.5}, 1e-6);
  EXPECT_EQ(world_.GetVelocity(plank).omega, 0.0);

  world_.ApplyLinearImpulse(plank, impulse, point);
  const double turn = Cross(point - center, impulse) / kPlankInertia;
  ExpectPoint(world_.GetVelocityAt(plank, center), {0.5, -1.0}, 1e-6);
  EXPECT_NEAR(world_.GetVelocity(plank).omega, turn, 1e-6);

  world_.ApplyAngularImpulse(plank, 0.7);
  ExpectPoint(world_.GetVelocityAt(plank, center), {0.5, -1.0}, 1e-6);
  EXPECT_NEAR(world_.GetVelocity(plank).omega, turn + 0.7 / kPlankInertia, 1e-6);
}

TEST_F(WorldTest, VelocityAtAPointIncludesTheRotation) {
  const World::Body plank = AddPlank(world_, {5, 6, 0.4});
  world_.SetVelocity(plank, {1, 2, 3});

  ExpectPoint(world_.GetVelocityAt(plank, {5, 6}), {1, 2}, 1e-5);
  ExpectPoint(world_.GetVelocityAt(plank, {7, 5}), {1 - 3 * -1.0, 2 + 3 * 2.0}, 1e-5);
}

TEST_F(WorldTest, PushesWakeABody) {
  const auto wakes = [&](const char* name, const std::function<void(World::Body)>& push) {
    const World::Body box = AddBox(world_, {0, 0, 0});
    StepTimes(world_, 200);
    ASSERT_FALSE(world_.IsAwake(box)) << name;

    push(box);

    EXPECT_TRUE(world_.IsAwake(box)) << name;
    world_.Step(kStep);
    const Twist velocity = world_.GetVelocity(box);
    EXPECT_GT(velocity.vx + velocity.omega, 0.0) << name;
    world_.RemoveBody(box);
  };
  wakes("force", [&](World::Body body) { world_.ApplyForce(body, Vec2{1, 0}); });
  wakes("force at a point", [&](World::Body body) { world_.ApplyForce(body, Vec2{1, 0}, Vec2{}); });
  wakes("torque", [&](World::Body body) { world_.ApplyTorque(body, 1); });
  wakes("impulse", [&](World::Body body) { world_.ApplyLinearImpulse(body, Vec2{1, 0}); });
  wakes("turning impulse", [&](World::Body body) { world_.ApplyAngularImpulse(body, 1); });
  wakes("velocity", [&](World::Body body) { world_.SetVelocity(body, Twist{1, 0, 0}); });
}

TEST_F(WorldTest, ConvertsPointsAndVectorsBetweenTheBodysFrameAndTheWorlds) {
  const World::Body plank = AddPlank(world_, {5, 6, M_PI / 2});

  ExpectPoint(world_.ToWorldPoint(plank, {2, 1}), {4, 8}, 1e-6);
  ExpectPoint(world_.ToLocalPoint(plank, {4, 8}), {2, 1}, 1e-6);
  ExpectPoint(world_.ToWorldVector(plank, {2, 1}), {-1, 2}, 1e-6);
  ExpectPoint(world_.ToLocalVector(plank, {-1, 2}), {2, 1}, 1e-6);
  ExpectPoint(world_.ToWorldPoint(plank, {0.3, 0.1}), world_.GetCenter(plank), 1e-5);
}

}  // namespace
}  // namespace flatland
