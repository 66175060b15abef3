/// Large layers: Box2D has their walls near dynamic bodies alone, and everything else is as in an
/// ordinary layer.

#include <gtest/gtest.h>

#include <random>
#include <stdexcept>
#include <string>
#include <vector>

#include "reference_walls.hpp"
#include "test_contact.hpp"

namespace flatland {
namespace {

/// Posts of four walls, 0.2 m wide, on a grid of 1 m from -60 to 60 m: 57,600 walls.
std::vector<Segment> Posts() {
  std::vector<Segment> walls;
  for (int x = -60; x < 60; ++x) {
    for (int y = -60; y < 60; ++y) {
      const double left = x + 0.4, right = x + 0.6, low = y + 0.4, high = y + 0.6;
      walls.push_back({{left, low}, {right, low}});
      walls.push_back({{right, low}, {right, high}});
      walls.push_back({{right, high}, {left, high}});
      walls.push_back({{left, high}, {left, low}});
    }
  }
  return walls;
}

constexpr Pose kStart{0.03, 0.02, 0.1};

/// A driven box and one that is pushed, among posts; which layers are large can be chosen.
class Scene {
 public:
  explicit Scene(size_t large_layer = 0) : world(10, 10, large_layer) {
    layer = world.AddLayer(Posts(), 0b10);
    robot = AddBox(world, kStart, 0.3, OnLayers(0b11));
    box = AddBox(world, {1.05, 0.1, 0.2}, 0.3, OnLayers(0b10));
    drive = world.AddDrive(robot, {}, {});
    world.Get(drive).Command({1.0, 0, 0.05});
  }

  std::vector<Pose> Run(int steps) {
    std::vector<Pose> poses;
    for (int i = 0; i < steps; ++i) {
      world.Step(0.01);
      poses.push_back(world.GetPose(robot));
      poses.push_back(world.GetPose(box));
    }
    return poses;
  }

  World world;
  World::Body layer;
  World::Body robot;
  World::Body box;
  World::Drive drive;
};

void ExpectSame(const std::vector<Pose>& a, const std::vector<Pose>& b) {
  ASSERT_EQ(a.size(), b.size());
  for (size_t i = 0; i < a.size(); ++i) {
    ASSERT_EQ(a[i].x, b[i].x) << i;
    ASSERT_EQ(a[i].y, b[i].y) << i;
    ASSERT_EQ(a[i].yaw, b[i].yaw) << i;
  }
}

TEST(LargeLayer, BodiesMeetItsWallsAsInAnOrdinaryLayer) {
  Scene large, ordinary(World::kLargeLayer);

  const std::vector<Pose> poses = large.Run(100), expected = ordinary.Run(100);

  for (size_t i = 0; i < poses.size(); ++i) ExpectPose(poses[i], expected[i], 1e-3);
  ASSERT_FALSE(large.world.contacts().GetTouches().empty());
  ASSERT_EQ(large.world.contacts().GetTouches().size(),
            ordinary.world.contacts().GetTouches().size());
  EXPECT_EQ(large.world.contacts().GetTouches()[0].a.index,
            ordinary.world.contacts().GetTouches()[0].a.index);
  EXPECT_EQ(large.world.body_count(), ordinary.world.body_count());
  EXPECT_EQ(ordinary.world.held_wall_count(), 0);
}

TEST(LargeLayer, Box2DHasTheWallsNearDynamicBodies) {
  Scene scene;
  scene.Run(1);
  const int near_two = scene.world.held_wall_count();
  EXPECT_GT(near_two, 4 * 30);  // posts within 3 m
  EXPECT_LT(near_two, 4 * 300);

  scene.world.SetPose(scene.robot, {40, 40, 0});
  scene.Run(1);
  EXPECT_GT(scene.world.held_wall_count(), near_two);

  scene.world.RemoveBody(scene.robot);
  scene.world.RemoveBody(scene.box);
  EXPECT_EQ(scene.world.held_wall_count(), 0);
  const World::Body other = AddBox(scene.world, {0, 0, 0}, 0.3, OnLayers(0b01));
  AddPost(scene.world, {5, 5, 0});
  StepTimes(scene.world, 1);
  EXPECT_EQ(scene.world.held_wall_count(), 0);  // on another layer

  scene.world.AddCircle(other, {0, 0}, 0.1, OnLayers(0b10));
  StepTimes(scene.world, 1);
  EXPECT_GT(scene.world.held_wall_count(), 0);
}

TEST(LargeLayer, ABodyThatIsFastOrMovedFarMeetsItsWalls) {
  World world(10, 10, 0);
  world.AddLayer({{{50, -5}, {50, 5}}, {{-50, -5}, {-50, 5}}}, kAllLayers);
  const World::Body box = AddBox(world, {0, 0, 0});
  world.SetVelocity(box, {300, 0, 0});  // 1.5 m in a step
  StepTimes(world, 100);
  EXPECT_NEAR(world.GetPose(box).x, 49.5, kSkin);

  world.SetPose(box, {-45, 0, 0});
  world.SetVelocity(box, {-10, 0, 0});
  StepTimes(world, 200);
  EXPECT_NEAR(world.GetPose(box).x, -49.5, kSkin);
}

TEST(LargeLayer, EventsNameItsWalls) {
  Scene scene;
  Recorder recorder;
  scene.world.contacts().SetListener(&recorder);
  scene.world.contacts().ListenTo(scene.layer, kBeginContact | kEndContact);
  scene.Run(200);
  scene.world.SetPose(scene.robot, {40, 40, 0});
  scene.world.SetPose(scene.box, {-40, 40, 0});
  scene.Run(1);

  ASSERT_GT(recorder.Count(kBeginContact), 0);
  EXPECT_EQ(recorder.Count(kBeginContact), recorder.Count(kEndContact));
  const Event& first = recorder.events.front();
  EXPECT_EQ(first.a.body.index, scene.layer.index);
  const Segment wall = Posts()[first.a.index];
  ASSERT_FALSE(first.points.empty());
  EXPECT_LT(std::abs(first.points[0].x - wall.a.x), 0.25);
  EXPECT_LT(std::abs(first.points[0].y - wall.a.y), 0.25);
}

TEST(LargeLayer, ARestoredWorldGoesOnLikeTheSavedOne) {
  Scene saved;
  saved.world.SetFriction({saved.layer, 7}, 0.5);
  saved.Run(150);
  const std::string state = saved.world.SaveState();
  Scene restored;
  restored.world.SetPose(restored.robot, {-30, 20, 1});
  restored.Run(30);

  restored.world.RestoreState(state);

  EXPECT_EQ(restored.world.GetSettings({restored.layer, 7}).friction, 0.5);
  EXPECT_EQ(restored.world.held_wall_count(), saved.world.held_wall_count());
  ExpectSame(restored.Run(300), saved.Run(300));
}

TEST(LargeLayer, EqualWorldsMakeEqualSteps) {
  Scene one, other;
  ExpectSame(one.Run(500), other.Run(500));
}

TEST(LargeLayer, ItsWallsHaveSettings) {
  Scene scene;
  EXPECT_EQ(scene.world.GetFixtureCount(scene.layer), 57'600);
  const Fixture wall{scene.layer, 57'599};
  EXPECT_EQ(scene.world.GetSettings(wall).layers, 0b10);
  EXPECT_FLOAT_EQ(scene.world.GetSettings(wall).friction, 0.2f);
  EXPECT_FALSE(scene.world.TestPoint(wall, {0, 0}));
  EXPECT_THROW(scene.world.GetSettings({scene.layer, 57'600}), std::invalid_argument);
  EXPECT_THROW(scene.world.SetFriction({scene.layer, 57'600}, 1), std::invalid_argument);

  scene.world.SetFriction(wall, 0.75);
  scene.world.SetRestitution(wall, 0.25);
  EXPECT_EQ(scene.world.GetSettings(wall).friction, 0.75);
  EXPECT_EQ(scene.world.GetSettings(wall).restitution, 0.25);
}

TEST(LargeLayer, AWallBouncesBackAsItWasToldBefore) {
  for (const bool is_near : {false, true}) {
    World world(10, 10, 0);
    const World::Body layer = world.AddLayer({{{50, -5}, {50, 5}}}, kAllLayers);
    const World::Body box = AddBox(world, {is_near ? 48.0 : 0.0, 0, 0});
    StepTimes(world, 1);
    world.SetRestitution({layer, 0}, 1.0);
    world.SetPose(box, {48, 0, 0});
    world.SetVelocity(box, {4, 0, 0});
    StepTimes(world, 100);
    EXPECT_NEAR(world.GetVelocity(box).vx, -4.0, 1e-3);
  }
}

TEST(LargeLayer, OverlapsAreFoundWithoutAStep) {
  Scene scene;
  EXPECT_TRUE(scene.world.GetOverlappingBodies(scene.robot).empty());
  for (const int steps : {0, 1}) {
    scene.world.SetPose(scene.robot, {20.35, 20.5, 0});
    StepTimes(scene.world, steps);
    scene.world.SetPose(scene.robot, {20.35, 20.5, 0});
    const std::vector<World::Body> bodies = scene.world.GetOverlappingBodies(scene.robot);
    ASSERT_EQ(bodies.size(), 1u);
    EXPECT_EQ(bodies[0].index, scene.layer.index);
    const std::vector<World::Body> of_layer = scene.world.GetOverlappingBodies(scene.layer);
    ASSERT_EQ(of_layer.size(), 1u);
    EXPECT_EQ(of_layer[0].index, scene.robot.index);
  }
}

TEST(LargeLayer, ALayerCanBeAddedLater) {
  World world(10, 10, 0);
  world.AddLayer({{{0, 5}, {1, 5}}}, kAllLayers);
  const World::Body box = AddBox(world, {0, 0, 0});
  world.SetVelocity(box, {2, 0, 0});
  StepTimes(world, 10);

  world.AddLayer({{{2, -5}, {2, 5}}}, kAllLayers);
  StepTimes(world, 400);

  EXPECT_NEAR(world.GetPose(box).x, 1.5, kSkin);
}

TEST(LargeLayer, ACopyHasAllWalls) {
  Scene scene;
  const std::unique_ptr<World> copy = scene.world.Copy();
  for (int i = 0; i < 100; ++i) {
    scene.world.Step(0.01);
    copy->Step(0.01);
  }
  EXPECT_EQ(copy->held_wall_count(), 0);
  EXPECT_EQ(copy->GetFixtureCount(scene.layer), 57'600);
  ExpectPose(copy->GetPose(scene.robot), scene.world.GetPose(scene.robot), 1e-3);
}

TEST(LargeLayer, ScansAreTheSame) {
  const std::vector<Segment> walls = RandomWalls(400, 2.0);
  size_t reported = 0;
  const SegmentTree large(walls, [&](size_t done) { reported = done; });
  const SegmentTree ordinary(walls);
  EXPECT_EQ(reported, walls.size());
  const BeamFan fan(-M_PI, 2 * M_PI / 360, 360);
  std::vector<float> ranges(360), expected(360);
  std::mt19937 random(3);
  for (int i = 0; i < 200; ++i) {
    const Vec2 at = RandomPoint(random, {-1, -1}, {21, 11});
    for (const auto& [tree, out] : {std::pair(&large, &ranges), std::pair(&ordinary, &expected)}) {
      DepthBuffer buffer;
      buffer.Begin(fan, kFar);
      buffer.Draw(*tree, {at.x, at.y, 0.3});
      buffer.GetRanges(out->data());
    }
    ASSERT_EQ(ranges, expected);
  }
}

}  // namespace
}  // namespace flatland
