/// Layers that another world takes: it makes the steps of a new world.

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "flatland_server/world.hpp"
#include "test_bodies.hpp"

namespace flatland {
namespace {

/// A room, and rubble in it.
std::vector<Segment> Walls(double size) {
  std::vector<Segment> walls{{{-size, -size}, {size, -size}},
                             {{size, -size}, {size, size}},
                             {{size, size}, {-size, size}},
                             {{-size, size}, {-size, -size}}};
  for (int i = 0; i < 60; ++i) {
    const Vec2 at{0.7 * std::sin(9.0 * i) * size, 0.7 * std::cos(7.0 * i) * size};
    walls.push_back({at, at + Vec2{0.3, 0.1 * (i % 5)}});
  }
  return walls;
}

/// Layers as of a file, then bodies as of models.
struct Trial {
  explicit Trial(std::size_t large_layer = World::kLargeLayer) : world(10, 10, large_layer) {}

  void AddLayers() {
    world.AddLayer(Walls(4.0), kAllLayers);
    world.AddLayer(Walls(3.0), 2);
  }
  void AddBodies() {
    for (int i = 0; i < 8; ++i) {
      bodies.push_back(AddBox(world, {0.9 * i - 3.0, 0.4 * (i % 3), 0.1 * i}, 0.4));
      world.SetVelocity(bodies.back(), {4.0 * std::sin(3.0 * i), 4.0 * std::cos(i), 1.0});
    }
  }
  void Run(int steps) {
    for (int i = 0; i < steps; ++i) world.Step(kStep);
  }
  /// Takes the layers of a world that has been used, as a reset does.
  void TakeFrom(Trial& former, const Trial& equal) {
    ASSERT_TRUE(world.TakeLayers(former.world, equal.world));
  }

  World world;
  std::vector<World::Body> bodies;
};

void ExpectSameRun(Trial& a, Trial& b) {
  for (int step = 0; step < 400; ++step) {
    for (Trial* each : {&a, &b}) each->Run(1);
    for (std::size_t i = 0; i < a.bodies.size(); ++i) {
      const Pose one = a.world.GetPose(a.bodies[i]), other = b.world.GetPose(b.bodies[i]);
      ASSERT_EQ(one.x, other.x) << "step " << step;
      ASSERT_EQ(one.y, other.y) << "step " << step;
      ASSERT_EQ(one.yaw, other.yaw) << "step " << step;
    }
  }
  EXPECT_FALSE(a.world.contacts().GetTouches().empty());
}

class WorldReuseTest : public testing::TestWithParam<std::size_t> {
 protected:
  WorldReuseTest() {
    for (Trial* each : {&fresh_, &former_, &equal_}) each->AddLayers();
    equal_.world.RememberLayers();
    fresh_.AddBodies();
  }

  Trial fresh_{GetParam()}, former_{GetParam()}, equal_{GetParam()};
};

// Box2D has all walls, or only those near bodies.
INSTANTIATE_TEST_SUITE_P(Layers, WorldReuseTest, testing::Values(World::kLargeLayer, 1));

TEST_P(WorldReuseTest, MakesTheStepsOfANewWorld) {
  former_.AddBodies();
  former_.world.AddRevolute(former_.bodies[0], former_.bodies[1], {});
  former_.world.AddWeld(former_.bodies[2], former_.world.GetLayers()[0], {});
  former_.world.AddDrive(former_.bodies[3], {}, {});
  former_.Run(300);
  former_.world.RemoveBody(former_.bodies[4]);
  former_.world.AddLayer(Walls(2.0), kAllLayers);
  for (int i = 0; i < 40; ++i) AddBox(former_.world, {0.15 * i - 3, 0.1 * i - 2, 0}, 0.1);
  former_.Run(50);
  Trial again(GetParam());
  again.TakeFrom(former_, equal_);
  EXPECT_EQ(again.world.body_count(), 2);
  EXPECT_EQ(again.world.joint_count(), 0);
  again.AddBodies();
  ExpectSameRun(fresh_, again);
}

TEST_P(WorldReuseTest, AndAgainAfterASavedState) {
  former_.AddBodies();
  former_.Run(20);
  former_.world.SaveState();
  Trial second(GetParam());
  second.TakeFrom(former_, equal_);
  second.AddBodies();
  second.Run(100);
  Trial third(GetParam());
  third.TakeFrom(equal_, second);
  third.AddBodies();
  ExpectSameRun(fresh_, third);
}

TEST_P(WorldReuseTest, WallsHaveTheirFirstMaterial) {
  const World::Body layer = former_.world.GetLayers()[0];
  const FixtureSettings before = former_.world.GetSettings({layer, 3});
  former_.world.SetFriction({layer, 3}, 0.9);
  former_.world.SetRestitution({layer, 5}, 0.8);
  Trial again(GetParam());
  again.TakeFrom(former_, equal_);
  const World::Body taken = again.world.GetLayers()[0];
  EXPECT_EQ(again.world.GetSettings({taken, 3}).friction, before.friction);
  EXPECT_EQ(again.world.GetSettings({taken, 5}).restitution, before.restitution);
}

TEST_P(WorldReuseTest, HandlesOfTheFormerWorldAreGone) {
  former_.AddBodies();
  const World::Body layer = former_.world.GetLayers()[0];
  const World::Joint joint = former_.world.AddRevolute(former_.bodies[0], former_.bodies[1], {});
  Trial again(GetParam());
  again.TakeFrom(former_, equal_);
  EXPECT_THROW(former_.world.GetPose(layer), GoneError);
  EXPECT_THROW(former_.world.GetPose(former_.bodies[0]), GoneError);
  EXPECT_THROW(former_.world.GetJointAngle(joint), GoneError);
  EXPECT_EQ(former_.world.body_count(), 0);
  former_.AddLayers();
  former_.bodies.clear();
  former_.AddBodies();
  ExpectSameRun(fresh_, former_);  // an empty world like any other
}

TEST(KnownWallsTest, MakeTheStepsOfANewWorld) {
  Trial fresh, saved, again;
  fresh.AddLayers();
  saved.world.AddLayer(Walls(4.0), kAllLayers);
  saved.world.SaveState();  // its tree is known, and that of the next world with these walls
  again.AddLayers();
  for (Trial* each : {&fresh, &again}) each->AddBodies();
  ExpectSameRun(fresh, again);
  EXPECT_EQ(fresh.world.SaveState(), again.world.SaveState());
}

TEST_P(WorldReuseTest, OtherLayersStay) {
  Trial other(GetParam());
  other.world.AddLayer(Walls(4.0), 4);
  Trial again(GetParam());
  EXPECT_FALSE(again.world.TakeLayers(other.world, equal_.world));
  EXPECT_FALSE(again.world.TakeLayers(former_.world, fresh_.world));  // it remembers none
  EXPECT_EQ(other.world.body_count(), 1);
  EXPECT_EQ(former_.world.body_count(), 2);
  EXPECT_EQ(again.world.body_count(), 0);
}

TEST_P(WorldReuseTest, NeedsWorldsOfTheRightKind) {
  EXPECT_THROW(fresh_.world.RememberLayers(), std::invalid_argument);
  EXPECT_THROW(fresh_.world.TakeLayers(former_.world, equal_.world), std::invalid_argument);
  Trial empty(GetParam());
  EXPECT_THROW(empty.world.TakeLayers(empty.world, equal_.world), std::logic_error);
}

}  // namespace
}  // namespace flatland
