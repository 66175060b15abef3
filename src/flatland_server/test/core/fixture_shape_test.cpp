/// Replacing the shape or layers of fixtures while the world runs.

#include <gtest/gtest.h>

#include <stdexcept>
#include <string>
#include <vector>

#include "test_contact.hpp"

namespace flatland {
namespace {

/// The range of a beam from the origin along x, on some layers.
float Look(World& world, LayerBits layers = kAllLayers) {
  float range = -1.0f;
  world.lidars().Scan(BeamFan(0, 0, 1), {}, {20.0, layers, 0}, &range, nullptr);
  return range;
}

TEST_F(WorldTest, ALidarSeesTheNewShapeAndLayers) {
  for (const b2BodyType type : {b2_staticBody, b2_dynamicBody}) {
    const World::Body body = world_.AddBody(At({5, 0, 0}, type));
    const Fixture disc = world_.AddCircle(body, {0, 0}, 0.5, OnLayers(0b01));
    EXPECT_NEAR(Look(world_), 4.5, 1e-5);

    world_.SetCircle(disc, {0, 0}, 1.5, 0b01);
    EXPECT_NEAR(Look(world_), 3.5, 1e-5);
    world_.SetPolygon(disc, Square(2), 0b01);
    EXPECT_NEAR(Look(world_), 4.0, 1e-5);
    world_.SetCircle(disc, {1, 0}, 0.5, 0b10);
    EXPECT_NEAR(Look(world_, 0b10), 5.5, 1e-5);
    EXPECT_GT(Look(world_, 0b01), 20.0);
    world_.RemoveBody(body);
  }
}

TEST_F(ContactTest, ContactsEndAndTheNextStepFindsTheNewOnes) {
  AddWallAt(2);
  const World::Body ball = AddBall({1, 0, 0});
  world_.contacts().ListenTo(ball, kBeginContact | kEndContact);
  StepTimes(1);
  EXPECT_EQ(recorder_.Story(), "");

  world_.SetCircle({ball, 0}, {0, 0}, 1.2);
  StepTimes(1);
  EXPECT_EQ(recorder_.Story(), "b");
  recorder_.action = [&](Contact&) { EXPECT_EQ(world_.GetSettings({ball, 0}).density, 1.0); };
  world_.SetPolygon({ball, 0}, Square(2.6));
  EXPECT_EQ(recorder_.Story(), "be");
  recorder_.action = {};
  StepTimes(100);
  EXPECT_EQ(recorder_.Story(), "beb");
  EXPECT_NEAR(world_.GetPose(ball).x, 0.7, kSkin);  // it was pushed out
  world_.SetCircle({ball, 0}, {0, 0}, 1.5, 0);
  StepTimes(1);
  EXPECT_EQ(recorder_.Story(), "bebe");
}

TEST_F(WorldTest, WhatDoesNotCollideDoesNotOnOtherLayersEither) {
  const World::Body box = AddBox(world_, {0, 0, 0});
  const Fixture disc = world_.AddCircle(AddPost(world_, {0, 0, 0}), {0, 0}, 0.5, Ghost());

  world_.SetCircle(disc, {0, 0}, 0.5, 0);
  world_.SetCircle(disc, {0, 0}, 1.0, kAllLayers);

  EXPECT_TRUE(world_.GetOverlappingBodies(box).empty());
  const Fixture solid = world_.AddCircle(disc.body, {0, 0}, 0.5, Solid());
  world_.SetCircle(solid, {0, 0}, 0.5, 0);
  EXPECT_TRUE(world_.GetOverlappingBodies(box).empty());
  world_.SetCircle(solid, {0, 0}, 0.5, kAllLayers);
  EXPECT_EQ(world_.GetOverlappingBodies(box).size(), 1u);
}

TEST_F(WorldTest, AStaticBodyThatGrowsPushesASleepingOne) {
  const World::Body post = AddPost(world_, {0, 0, 0});
  const Fixture disc = world_.AddCircle(post, {0, 0}, 0.5, Solid());
  const World::Body box = AddBox(world_, {1.5, 0, 0});
  StepTimes(world_, 200);
  ASSERT_FALSE(world_.IsAwake(box));

  world_.SetCircle(disc, {0, 0}, 1.2);
  StepTimes(world_, 200);

  EXPECT_NEAR(world_.GetPose(box).x, 1.7, kSkin);
}

TEST_F(WorldTest, ABodyThatGrowsMeetsTheWallsOfALargeLayer) {
  World world(10, 10, 0);
  world.AddLayer({{{20, -5}, {20, 5}}}, 0b10);
  const World::Body ball = world.AddBody({});
  const Fixture disc = world.AddCircle(ball, {0, 0}, 0.5, OnLayers(0b01));
  StepTimes(world, 1);

  world.SetCircle(disc, {0, 0}, 20.2, 0b10);
  StepTimes(world, 200);

  EXPECT_NEAR(world.GetPose(ball).x, -0.2, kSkin);
}

TEST_F(WorldTest, TheMassIsThatOfABodyMadeWithTheNewShape) {
  const auto add = [&](double side) {
    const World::Body body = world_.AddBody(At({1, 2, 0.5}));
    world_.AddPolygon(body, Square(side), Solid());
    // Box2D asserts the inertia of this one alone.
    world_.AddCircle(body, {1000, 0}, 0.01, OnLayers(0b10));
    return body;
  };
  const World::Body changed = add(100), expected = add(200);
  world_.SetVelocity(changed, {1, 0, 0.5});

  world_.SetPolygon({changed, 0}, Square(200));

  EXPECT_EQ(world_.GetMass(changed), world_.GetMass(expected));
  EXPECT_EQ(world_.GetInertia(changed), world_.GetInertia(expected));
  EXPECT_EQ(world_.GetCenter(changed).x, world_.GetCenter(expected).x);
  ExpectTwist(world_.GetVelocity(changed), {1, 0, 0.5}, 1e-4);

  const World::Body weightless = world_.AddBody({});
  const Fixture disc = world_.AddCircle(weightless, {0, 0}, 1, {});
  const double mass = world_.GetMass(weightless);
  world_.SetCircle(disc, {0, 0}, 2);
  EXPECT_EQ(world_.GetMass(weightless), mass);
}

TEST_F(WorldTest, RefusesAShapeThatTheBodyCannotHave) {
  const World::Body wall = world_.AddLayer({{{9, -5}, {9, 5}}}, kAllLayers);
  const World::Body body = world_.AddBody(At({5, 0, 0}));
  const Fixture disc = world_.AddCircle(body, {0, 0}, 0.5, Solid());
  const Fixture gone = world_.AddCircle(world_.AddBody({}), {0, 0}, 0.5, Solid());
  world_.RemoveBody(gone.body);

  for (const double radius : {-1.0, 0.0, std::nan("")}) {
    EXPECT_THROW(world_.SetCircle(disc, {0, 0}, radius), std::invalid_argument);
  }
  EXPECT_THROW(world_.SetPolygon(disc, {{0, 0}, {1, 1}, {2, 2}}), std::invalid_argument);
  EXPECT_THROW(world_.SetCircle(disc, {1000, 0}, 0.001), std::invalid_argument);
  EXPECT_THROW(world_.SetCircle({wall, 0}, {0, 0}, 1), std::invalid_argument);
  EXPECT_THROW(world_.SetCircle({body, 1}, {0, 0}, 1), std::invalid_argument);
  EXPECT_THROW(world_.SetCircle(gone, {0, 0}, 1), GoneError);

  EXPECT_NEAR(Look(world_), 4.5, 1e-5);
  EXPECT_EQ(world_.GetSettings(disc).layers, kAllLayers);
}

TEST_F(WorldTest, AStateIsRestoredToAWorldOfTheSameShapes) {
  struct Scene {
    World world{10, 10};
    World::Body post = AddPost(world, {0, 0, 0});
    World::Body ball = AddBox(world, {1.2, 0.1, 0.3});
    Scene() { world.AddCircle(post, {0, 0}, 0.5, Solid()); }
    void Change() {
      world.SetCircle({post, 0}, {0, 0}, 0.9);
      world.SetCircle({ball, 0}, {0.1, 0}, 0.4);
    }
    Pose Run(int steps) {
      for (int i = 0; i < steps; ++i) {
        world.ApplyForce(ball, {-1, 0});
        world.Step(kStep);
      }
      return world.GetPose(ball);
    }
  } saved, restored;
  saved.Run(50);
  saved.Change();
  saved.Run(50);
  const std::string state = saved.world.SaveState();

  restored.Change();
  restored.world.RestoreState(state);

  const Pose pose = restored.Run(200), expected = saved.Run(200);
  EXPECT_EQ(pose, expected);
  EXPECT_EQ(restored.world.SaveState(), saved.world.SaveState());
}

}  // namespace
}  // namespace flatland
