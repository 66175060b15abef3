/// Fixtures: their settings and shapes.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <vector>

#include "test_bodies.hpp"
#include "world/world.hpp"

namespace flatland {
namespace {

TEST_F(WorldTest, KnowsTheSettingsOfAFixture) {
  const World::Body body = world_.AddBody({});
  const FixtureSettings special{2.5, 0.75, 0.5, true, false, false, 0b1010};
  const Fixture plain = world_.AddCircle(body, {0, 0}, 1.0, {});
  const Fixture square = world_.AddPolygon(body, Square(1), special);

  EXPECT_EQ(world_.GetFixtureCount(body), 2);
  for (const auto& [fixture, expected] : {std::pair{plain, FixtureSettings{}}, {square, special}}) {
    const FixtureSettings found = world_.GetSettings(fixture);
    EXPECT_EQ(found.density, expected.density);
    EXPECT_EQ(found.friction, expected.friction);
    EXPECT_EQ(found.restitution, expected.restitution);
    EXPECT_EQ(found.sensor, expected.sensor);
    EXPECT_EQ(found.collides, expected.collides);
    EXPECT_EQ(found.visible, expected.visible);
    EXPECT_EQ(found.layers, expected.layers);
  }
}

TEST_F(WorldTest, ChangesFrictionAndRestitutionOfAFixture) {
  world_.AddLayer({{{2, -5}, {2, 5}}}, 0xFFFF);
  const World::Body box = AddBox(world_, {0, 0, 0});

  world_.SetRestitution({box, 0}, 0.5);
  world_.SetFriction({box, 0}, 0.25);

  EXPECT_EQ(world_.GetSettings({box, 0}).restitution, 0.5);
  EXPECT_EQ(world_.GetSettings({box, 0}).friction, 0.25);
  world_.SetVelocity(box, {4, 0, 0});
  StepTimes(world_, 200);
  EXPECT_NEAR(world_.GetVelocity(box).vx, -2.0, 1e-3);
}

TEST_F(WorldTest, KnowsWhetherAPointIsWithinAFixture) {
  const World::Body body = world_.AddBody(At({5, 6, M_PI / 2}));
  const Fixture circle = world_.AddCircle(body, {2, 0}, 0.5, Solid());
  const Fixture square = world_.AddPolygon(body, Square(1), Solid());

  EXPECT_TRUE(world_.TestPoint(circle, {5, 8.4}));
  EXPECT_FALSE(world_.TestPoint(circle, {5, 8.6}));
  EXPECT_FALSE(world_.TestPoint(circle, {5.4, 6.4}));
  EXPECT_TRUE(world_.TestPoint(square, {5.4, 6.4}));
  EXPECT_FALSE(world_.TestPoint(square, {7, 6}));
}

TEST_F(WorldTest, WhatIsNotVisibleCollidesButIsNotSeen) {
  FixtureSettings glass = Solid();
  glass.visible = false;
  const World::Body box = AddBox(world_, {3, 0, 0}, 1.0, glass);
  AddBox(world_, {6, 0, 0});
  ScanSettings lidar;
  lidar.range = 20.0;
  const auto look = [&] {
    float range = -1.0f, intensity = -1.0f;
    world_.lidars().Scan(BeamFan(0, 0, 1), {}, lidar, &range, &intensity);
    return range;
  };

  EXPECT_NEAR(look(), 5.5, 1e-4);

  // Each fixture of a body has a visibility of its own.
  world_.AddCircle(box, {0, 0}, 0.2, Solid());
  EXPECT_NEAR(look(), 2.8, 1e-4);

  const World::Body thrown = AddBox(world_, {3, 3, 0});
  world_.SetVelocity(thrown, {0, -2, 0});
  StepTimes(world_, 400);
  EXPECT_GT(world_.GetPose(thrown).y, world_.GetPose(box).y + 0.9);
}

// Box2D sums up in single precision, fixture by fixture, which 10,000 fixtures make inexact.
TEST_F(WorldTest, TheMassOfManyFixturesIsTheirSum) {
  const World::Body body = world_.AddBody({});
  constexpr int kCount = 10'000;
  for (int i = 0; i < kCount; ++i) world_.AddPolygon(body, Square(0.1), Solid());
  world_.AddPolygon(body, Square(100), {});  // without a density

  EXPECT_NEAR(world_.GetMass(body), kCount * 0.01, 1e-4);
  EXPECT_NEAR(world_.GetInertia(body), kCount * 0.01 * 2 * 0.01 / 12.0, 1e-6);
}

TEST_F(WorldTest, TheCentreOfMassIsThatOfTheFixturesTogether) {
  const World::Body body = world_.AddBody({});
  world_.AddPolygon(body, {{0, 0}, {1, 0}, {0.5, 0.2}, {1, 1}, {0, 1}}, Solid());  // their hull
  world_.AddPolygon(body, {{4, 0}, {5, 0}, {5, 1}, {4, 1}}, Dense(3.0));

  EXPECT_NEAR(world_.GetMass(body), 4.0, 1e-6);
  EXPECT_NEAR(world_.GetCenter(body).x, (0.5 + 3 * 4.5) / 4, 1e-6);
  EXPECT_NEAR(world_.GetCenter(body).y, 0.5, 1e-6);
}

// Overlaps

TEST_F(WorldTest, ABodyWithoutMassWeighsAKilogram) {
  world_.AddLayer({{{2, -5}, {2, 5}}}, kAllLayers);
  FixtureSettings weightless;
  const World::Body body = AddBox(world_, {0, 0, 0}, 1.0, weightless);
  const World::Body pushed = AddBox(world_, {1, 0, 0}, 0.5, weightless);
  const std::unique_ptr<World> copy = world_.Copy();
  for (World* world : {&world_, copy.get()}) {
    EXPECT_EQ(world->GetMass(body), 1.0);
    EXPECT_EQ(world->GetMass(world->AddBody({})), 1.0);
    for (int step = 0; step < 600; ++step) {
      world->SetVelocity(body, {1, 0, 0});
      world->Step(kStep);
    }
    EXPECT_NEAR(world->GetPose(pushed).x, 1.75, 0.05);
    EXPECT_NEAR(world->GetPose(body).x, 1.0, 0.1);
    world->SetPolygon({body, 0}, Square(0.8));
    EXPECT_EQ(world->GetMass(body), 1.0);
  }
}

TEST_F(WorldTest, ABodyKnowsWhatItOverlaps) {
  const World::Body wall = world_.AddLayer({{{0, -5}, {0, 5}}}, kAllLayers);
  const World::Body in_wall = AddBox(world_, {0.4, 0, 0});
  const World::Body free = AddBox(world_, {3, 0, 0});
  const World::Body in_box = world_.AddBody(At({0.9, 0, 0}));
  world_.AddCircle(in_box, {0, 0}, 0.2, Solid());

  const auto ids = [&](World::Body body) {
    std::vector<uint32_t> found;
    for (const World::Body& other : world_.GetOverlappingBodies(body)) found.push_back(other.index);
    std::sort(found.begin(), found.end());
    return found;
  };
  EXPECT_EQ(ids(in_wall), (std::vector<uint32_t>{wall.index, in_box.index}));
  EXPECT_EQ(ids(in_box), std::vector<uint32_t>{in_wall.index});
  EXPECT_EQ(ids(free), std::vector<uint32_t>{});
}

TEST_F(WorldTest, WhatDoesNotPushOutDoesNotOverlap) {
  AddBox(world_, {0, 0, 0}, 1.0, Sensor());
  AddBox(world_, {0, 0, 0}, 1.0, Ghost());
  AddBox(world_, {0, 0, 0}, 1.0, OnLayers(0b10));
  EXPECT_TRUE(world_.GetOverlappingBodies(AddBox(world_, {0, 0, 0}, 1.0, OnLayers(0b01))).empty());

  const World::Body shelf = AddPost(world_, {9, 0, 0}), wall = AddPost(world_, {9, 0, 0});
  for (const World::Body each : {shelf, wall}) world_.AddCircle(each, {0, 0}, 1.0, Solid());
  EXPECT_TRUE(world_.GetOverlappingBodies(shelf).empty()) << "both are static";
}

// Box2D puts a skin of a centimetre around edges and polygons.
TEST_F(WorldTest, NearIsNotWithin) {
  world_.AddLayer({{{0, -5}, {0, 5}}}, kAllLayers);

  EXPECT_TRUE(world_.GetOverlappingBodies(AddBox(world_, {0.505, 0, 0})).empty());
  EXPECT_EQ(world_.GetOverlappingBodies(AddBox(world_, {0.499, 3, 0})).size(), 1u);
}

}  // namespace
}  // namespace flatland
