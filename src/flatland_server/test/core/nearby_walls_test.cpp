/// Layers: Box2D has their walls near dynamic bodies alone, and everything is as if it had all.

#include <gtest/gtest.h>

#include <array>
#include <random>
#include <stdexcept>
#include <string>
#include <vector>

#include "reference_walls.hpp"
#include "test_bodies.hpp"
#include "test_contact.hpp"

namespace flatland {
namespace {

/// Posts of four walls, 0.2 m wide, on a grid of 1 m: 57,600 walls if it goes from -60 to 60 m.
std::vector<Segment> Posts(int half = 60) {
  std::vector<Segment> walls;
  for (int x = -half; x < half; ++x) {
    for (int y = -half; y < half; ++y) {
      const double left = x + 0.4, right = x + 0.6, low = y + 0.4, high = y + 0.6;
      walls.push_back({{left, low}, {right, low}});
      walls.push_back({{right, low}, {right, high}});
      walls.push_back({{right, high}, {left, high}});
      walls.push_back({{left, high}, {left, low}});
    }
  }
  return walls;
}

constexpr Pose kBeside{0.03, 0.02, 0.1};

constexpr float kEverywhere = 1e4f;  // a room for which Box2D has all walls

/// A driven box and one that is pushed, among posts.
class Scene {
 public:
  explicit Scene(float room = World::kRoom) : world(10, 10, room) {
    layer = world.AddLayer(Posts(), 0b10);
    robot = AddBox(world, kBeside, 0.3, OnLayers(0b11));
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

TEST(NearbyWalls, BodiesMeetThemAsIfBox2DHadAll) {
  Scene scene, whole(kEverywhere);

  const std::vector<Pose> poses = scene.Run(100), expected = whole.Run(100);

  for (size_t i = 0; i < poses.size(); ++i) ExpectPose(poses[i], expected[i], 1e-3);
  ASSERT_FALSE(scene.world.contacts().GetTouches().empty());
  ASSERT_EQ(scene.world.contacts().GetTouches().size(), whole.world.contacts().GetTouches().size());
  EXPECT_EQ(scene.world.contacts().GetTouches()[0].a.index,
            whole.world.contacts().GetTouches()[0].a.index);
  EXPECT_EQ(scene.world.body_count(), whole.world.body_count());
  EXPECT_EQ(whole.world.held_wall_count(), 57'600);
}

TEST(NearbyWalls, Box2DHasTheWallsNearDynamicBodies) {
  Scene scene;
  scene.Run(1);
  const int near_two = scene.world.held_wall_count();
  EXPECT_GT(near_two, 4 * 4);  // posts within half a metre
  EXPECT_LT(near_two, 4 * 30);

  scene.world.SetPose(scene.robot, {40, 40, 0});
  scene.Run(1);
  EXPECT_GE(scene.world.held_wall_count(), near_two);

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

TEST(NearbyWalls, ABodyThatIsFastOrMovedFarMeetsItsWalls) {
  World world(10, 10);
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

TEST(NearbyWalls, EventsNameItsWalls) {
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

TEST(NearbyWalls, ARestoredWorldGoesOnLikeTheSavedOne) {
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

TEST(NearbyWalls, ItsWallsHaveSettings) {
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

TEST(NearbyWalls, AWallBouncesBackAsItWasToldBefore) {
  for (const bool is_near : {false, true}) {
    World world(10, 10);
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

TEST(NearbyWalls, OverlapsAreFoundWithoutAStep) {
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

TEST(NearbyWalls, ALayerCanBeAddedLater) {
  World world(10, 10);
  world.AddLayer({{{0, 5}, {1, 5}}}, kAllLayers);
  const World::Body box = AddBox(world, {0, 0, 0});
  world.SetVelocity(box, {2, 0, 0});
  StepTimes(world, 10);

  world.AddLayer({{{2, -5}, {2, 5}}}, kAllLayers);
  StepTimes(world, 400);

  EXPECT_NEAR(world.GetPose(box).x, 1.5, kSkin);
}

TEST(NearbyWalls, ACopyGoesOnBitForBit) {
  Scene scene;
  scene.world.SetFriction({scene.layer, 7}, 0.5);
  for (int round = 0; round < 5; ++round) {
    const std::unique_ptr<World> copy = scene.world.Copy();
    EXPECT_EQ(copy->held_wall_count(), scene.world.held_wall_count());
    EXPECT_EQ(copy->GetFixtureCount(scene.layer), 57'600);
    for (int i = 0; i < 100; ++i) {
      scene.world.Step(0.01);
      copy->Step(0.01);
    }
    EXPECT_EQ(copy->SaveState(), scene.world.SaveState()) << round;
  }
}

TEST(NearbyWalls, ARobotAtRestKeepsThem) {
  Scene scene;
  scene.world.Get(scene.drive).Command({});
  scene.Run(10);
  const int held = scene.world.held_wall_count();
  scene.Run(100);
  EXPECT_EQ(scene.world.held_wall_count(), held);
}

/// Single steps of bodies that collide among posts at random velocities. Contacts in another order
/// are solved differently: of worlds that hold all walls in another order, 4 are apart.
TEST(NearbyWalls, AStepIsThatOfAWorldThatHoldsAllWalls) {
  std::mt19937 random(5);
  std::uniform_real_distribution<double> unit(-1.0, 1.0);
  const std::vector<Segment> posts = Posts(8);
  int met = 0, apart = 0;
  for (int trial = 0; trial < 600; ++trial) {
    World near(10, 10), whole(10, 10, kEverywhere);
    const double dt = std::array{0.005, 0.05, 0.1}[trial % 3];
    const double speed = std::array{1.0, 13.0}[trial % 2];  // no step is divided
    std::vector<World::Body> bodies;
    for (World* world : {&near, &whole}) world->AddLayer(posts, kAllLayers);
    for (int i = 0; i < 4; ++i) {
      const Pose pose{0.35 * i + 0.05 * unit(random), 0.1 * unit(random), M_PI * unit(random)};
      const Twist velocity{speed * unit(random), speed * unit(random), 5 * unit(random)};
      for (World* world : {&near, &whole}) {
        if (i < 3) {
          bodies.push_back(AddBox(*world, pose, i % 2 == 0 ? 0.2 : 0.05));
        } else {  // it hits bodies that have been slow
          bodies.push_back(world->AddBody(At({0.35, 0.2, 0.0}, b2_kinematicBody)));
          world->AddPolygon(bodies.back(), Square(0.4), Solid());
        }
        world->SetVelocity(bodies.back(), velocity);
      }
    }
    near.Step(dt);
    whole.Step(dt);
    for (size_t i = 0; i < bodies.size(); i += 2) {
      const Pose a = near.GetPose(bodies[i]), b = whole.GetPose(bodies[i + 1]);
      apart += std::hypot(a.x - b.x, a.y - b.y) > 0.05;
    }
    met += near.contacts().GetTouches().size() > 0;
  }
  EXPECT_GT(met, 100);
  EXPECT_LE(apart, 6);
}

TEST(NearbyWalls, ScansAreTheSame) {
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
