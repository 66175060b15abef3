/// Layers: static bodies of walls, which stop bodies that share a layer with them.

#include <gtest/gtest.h>

#include <stdexcept>

#include "test_bodies.hpp"
#include "world/world.hpp"

namespace flatland {
namespace {

TEST_F(WorldTest, ALayerIsABodyOfWalls) {
  const World::Body layer = world_.AddLayer({{{0, 0}, {4, 0}}, {{4, 0}, {4, 3}}}, 0b101);

  EXPECT_TRUE(world_.Contains(layer));
  EXPECT_EQ(world_.GetType(layer), b2_staticBody);
  EXPECT_EQ(world_.GetFixtureCount(layer), 2);
  EXPECT_EQ(world_.GetSettings({layer, 1}).layers, 0b101);
  EXPECT_FALSE(world_.TestPoint({layer, 1}, {4, 1}));  // a wall is not thick
  ExpectPose(world_.GetPose(layer), {}, 0.0);
  EXPECT_EQ(world_.GetMass(layer), 0.0);
  EXPECT_THROW(world_.GetSettings({layer, 2}), std::invalid_argument);
}

TEST_F(WorldTest, ALayerCannotBeMovedOrRemoved) {
  const World::Body layer = world_.AddLayer({{{2, -5}, {2, 5}}}, 0xFFFF);

  EXPECT_THROW(world_.RemoveBody(layer), std::invalid_argument);
  EXPECT_THROW(world_.SetPose(layer, {1, 0, 0}), std::invalid_argument);
  EXPECT_THROW(world_.AddCircle(layer, {0, 0}, 1.0, Solid()), std::invalid_argument);
  EXPECT_THROW(world_.AddPolygon(layer, Square(1), Solid()), std::invalid_argument);

  // Forces do not move it either, and it still stops bodies.
  world_.SetVelocity(layer, {1, 0, 0});
  world_.ApplyForce(layer, {5, 0});
  world_.ApplyLinearImpulse(layer, {5, 0});
  const World::Body box = AddBox(world_, {0, 0, 0});
  world_.SetVelocity(box, {2, 0, 0});
  StepTimes(world_, 400);
  ExpectPose(world_.GetPose(layer), {}, 0.0);
  EXPECT_EQ(world_.GetFixtureCount(layer), 1);
  EXPECT_LT(world_.GetPose(box).x, 1.6);
}

// In a step the box moves by more than its own length.
TEST_F(WorldTest, FastBoxDoesNotPassThroughAWall) {
  world_.AddLayer({{{3.03, -5}, {3.03, 5}}}, 0xFFFF);
  const World::Body box = AddBox(world_, {0, 0, 0}, 0.04);
  world_.SetVelocity(box, {20, 0, 0});

  StepTimes(world_, 400);

  EXPECT_LT(world_.GetPose(box).x, 3.03);
  EXPECT_GT(world_.GetPose(box).x, 2.9);
}

TEST_F(WorldTest, DrivenBoxDoesNotPassThroughAWall) {
  world_.AddLayer({{{3.03, -5}, {3.03, 5}}}, 0xFFFF);
  const World::Body box = AddBox(world_, {0, 0, 0}, 0.4);
  world_.Get(world_.AddDrive(box, {}, {})).Command({20, 0, 0});

  StepTimes(world_, 400);

  EXPECT_LT(world_.GetPose(box).x, 3.03);
}

}  // namespace
}  // namespace flatland
