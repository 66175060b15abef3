/// Distances and intensities that a lidar measures: of walls and bodies, on its layers.

#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <functional>
#include <future>
#include <stdexcept>
#include <utility>
#include <vector>

#include "reference_walls.hpp"
#include "test_numbers.hpp"
#include "test_scan.hpp"
#include "world/world.hpp"

namespace flatland {
namespace {

TEST_F(LidarTest, SeesACircleAsItIsSetToBeSeen) {
  AddWallAt(10);
  const World::Body body = AddBody({5, 0, 0});
  const Fixture circle = world_.AddCircle(body, {0, 0}, 0.5, {});
  EXPECT_NEAR(LookAhead({}), 4.5, 1e-5);

  world_.SetSeenRadius(circle, 0.1);

  EXPECT_NEAR(LookAhead({}), 4.9, 1e-5);
  EXPECT_TRUE(world_.TestPoint(circle, {5.4, 0}));
  world_.SetVisible(circle, false);
  EXPECT_NEAR(LookAhead({}), 10.0, 1e-5);
  world_.SetVisible(circle, true);
  EXPECT_NEAR(LookAhead({}), 4.9, 1e-5);
  world_.SetCircle(circle, {0, 0}, 0.3);
  EXPECT_NEAR(LookAhead({}), 4.7, 1e-5);
  EXPECT_THROW(world_.SetSeenRadius(circle, kNaN), std::invalid_argument);
  const Fixture square = world_.AddPolygon(body, square_, {});
  EXPECT_THROW(world_.SetSeenRadius(square, 1.0), std::invalid_argument);
}

TEST_F(LidarTest, MeasuresInfinityWhereNothingIsInRange) {
  AddWallAt(5.0);
  const World::Body body = AddBody({0.0, 8.0, 0.0});
  world_.AddCircle(body, {0, 0}, 1.0, {});

  settings_.range = 4.9;
  for (float range : Look(forward_, {}).ranges) EXPECT_EQ(range, kInfinity);

  settings_.range = 7.1;
  EXPECT_EQ(LookAhead({}), 5.0f);
  EXPECT_NEAR(LookAhead({0, 0, M_PI / 2}), 7.0, 1e-5);
  EXPECT_EQ(LookAhead({0, 0, M_PI}), kInfinity);
}

// The near end of a wide body is in range, its far ends are not.
TEST_F(LidarTest, SeesOnlyThePartOfABodyThatIsInRange) {
  world_.AddPolygon(AddBody({3, 0, 0}), {{0, -10}, {1, -10}, {1, 10}, {0, 10}}, {});
  settings_.range = 5.0;

  EXPECT_EQ(LookAhead({}), 3.0f);
  settings_.range = 3.0;
  EXPECT_EQ(LookAhead({}), 3.0f) << "at its very range";
  settings_.range = 5.0;
  EXPECT_NEAR(LookAhead({0, 0, 0.9}), 3.0 / std::cos(0.9), 1e-4);
  EXPECT_EQ(LookAhead({0, 0, 0.95}), kInfinity);
  EXPECT_EQ(LookAhead({0, 0, -1.2}), kInfinity);
}

// Each corner of a shape in turn, far out, while all else is out of range.
TEST_F(LidarTest, SeesTheTipOfABody) {
  settings_.range = 2.0;
  for (int quarter = 0; quarter < 4; ++quarter) {
    const Rotation rotation(quarter * M_PI / 2);
    const World::Body body = AddBody({5, 0, M_PI - quarter * M_PI / 2});
    world_.AddPolygon(
        body, {rotation.Apply({3.1, 0}), rotation.Apply({0, 0.2}), rotation.Apply({0, -0.2})}, {});

    EXPECT_NEAR(LookAhead({}), 1.9, 1e-5) << quarter << " quarter turns";
    world_.RemoveBody(body);
  }
}

TEST_F(LidarTest, LooksOutOfABodyAroundIt) {
  AddWallAt(3.0);
  world_.AddCircle(AddBody({0.0, 4.0, 0.0}), {0, 0}, 1.0, {});
  const World::Body square = AddBody({0.1, 0.0, 0.3}), disc = AddBody({0.1, 0.0, 0.0});
  world_.AddPolygon(square, square_, {});
  for (const bool is_square : {true, false}) {
    EXPECT_EQ(LookAhead({}), 3.0f);
    EXPECT_NEAR(LookAhead({0, 0, M_PI / 2}), 3.0, 1e-5);
    EXPECT_EQ(LookAhead({0, 0, M_PI}), kInfinity);
    if (!is_square) continue;
    world_.RemoveBody(square);
    world_.AddCircle(disc, {0, 0}, 0.5, {});
  }
}

TEST_F(LidarTest, LooksOutOfABodyWithinAMillimetreOfItsOutline) {
  AddWallAt(30.0);
  const BeamFan around(-M_PI, 2.0 * M_PI / 360, 360);
  const auto looks_out = [&](const Pose& lidar) {
    const View view = Look(around, lidar);
    return std::all_of(view.ranges.begin(), view.ranges.end(), [](float r) { return r > 25.0f; });
  };
  for (int i = 0; i < 500; ++i) {
    const Pose pose{0.01 * i, 0.003 * i, 0.02 * i};
    const World::Body body = AddBody(pose);
    world_.AddPolygon(body, square_, {});
    const auto at = [&](Vec2 mount) {
      const Vec2 place = Vec2{pose.x, pose.y} + Rotation(pose.yaw).Apply(mount);
      return Pose{place.x, place.y, pose.yaw};
    };
    ASSERT_TRUE(looks_out(at({0.5, 0.5}))) << i;  // on a vertex
    ASSERT_TRUE(looks_out(at({0.5, 0.1}))) << i;
    ASSERT_TRUE(looks_out(at({0.5009, -0.2}))) << i;
    ASSERT_FALSE(looks_out(at({0.5011, -0.2}))) << i;
    world_.RemoveBody(body);
    const World::Body disc = AddBody(pose);
    world_.AddCircle(disc, {0, 0}, 0.5, {});
    ASSERT_TRUE(looks_out(at({0.3, 0.4}))) << i;
    ASSERT_FALSE(looks_out(at({0.3, 0.402}))) << i;
    world_.RemoveBody(disc);
  }
}

TEST_F(LidarTest, NeverMeasuresLessThanNothing) {
  world_.AddCircle(AddBody({0.0, 0.0, 0.0}), {0, 0}, 0.3, {});

  // On the circle itself, at every angle.
  for (double angle = 0.0; angle < 2.0 * M_PI; angle += 0.01) {
    const float radius = 0.3f;
    const Pose lidar{radius * std::cos(angle), radius * std::sin(angle), angle};
    for (float range : Look(forward_, lidar).ranges) ASSERT_GE(range, 0.0f) << angle;
  }
}

TEST_F(LidarTest, SeesTheNearestOfAll) {
  AddWallAt(6.0);
  AddWallAt(4.0);
  AddWallAt(5.0);
  EXPECT_EQ(LookAhead({}), 4.0f);

  world_.AddPolygon(AddBody({4.9, 0, 0}), square_, {});
  EXPECT_EQ(LookAhead({}), 4.0f);

  world_.AddPolygon(AddBody({2.5, 0, 0}), square_, {});
  world_.AddPolygon(AddBody({3.5, 0, 0}), square_, {});
  EXPECT_EQ(LookAhead({}), 2.0f);
}

TEST_F(LidarTest, SeesABodyWhereItHasMoved) {
  const World::Body body = AddBody({2.5, 0, 0});
  world_.AddPolygon(body, square_, {});

  world_.SetPose(body, {4.5, 0, 0});

  EXPECT_EQ(LookAhead({}), 4.0f);
}

// A body of which either side looks out from behind a wall.
TEST_F(LidarTest, SeesTheSideOfACircleThatAWallLeavesFree) {
  for (double side : {-1.0, 1.0}) {
    World world(10, 10);
    world.AddLayer({{{2, -0.1 * side}, {2, 5 * side}}}, 0xFFFF);
    AddDisc(world, {4, 0, 0}, 1.0);
    float range, intensity;
    world.lidars().Scan(BeamFan(-0.2 * side, 0.0, 1), {}, settings_, &range, &intensity);

    const double across = 4.0 * std::sin(0.2);
    EXPECT_NEAR(range, 4.0 * std::cos(0.2) - std::sqrt(1.0 - across * across), 1e-5) << side;
  }
}

TEST_F(LidarTest, SeesNoBodyBehindAWall) {
  AddWallAt(2.0);
  world_.AddPolygon(AddBody({3.0, 0, 0.2}), square_, {});
  world_.AddCircle(AddBody({4.0, 1, 0}), {0, 0}, 0.5, {});
  const View alone = Look(forward_, {});

  const World::Body before = AddBody({1.9, 0.3, 0});
  world_.AddCircle(before, {0, 0}, 0.3, {});
  const View with_one_before = Look(forward_, {});

  int seen = 0;
  for (int beam = 0; beam < forward_.size(); ++beam) {
    const double angle = -0.75 * M_PI + beam * 1.5 * M_PI / 1080;
    if (std::abs(angle) < 1.4) {
      ASSERT_NEAR(alone.ranges[beam], 2.0 / std::cos(angle), 1e-4);
    }
    if (with_one_before.ranges[beam] < alone.ranges[beam]) ++seen;
  }
  EXPECT_GT(seen, 20);

  world_.RemoveBody(before);
  EXPECT_EQ(Look(forward_, {}).ranges, alone.ranges);
}

TEST_F(LidarTest, MeasuresTheSameClockwiseInReverse) {
  AddWallAt(5.0);
  world_.AddPolygon(AddBody({2.0, 1.5, 0.4}), square_, {});
  world_.AddCircle(AddBody({-2.0, 0.5, 0.0}), {0, 0}, 0.7, {});
  const int count = 1000;
  const double increment = 2.0 * M_PI / count;
  const BeamFan fan(-M_PI, increment, count);
  const BeamFan clockwise(-M_PI + (count - 1) * increment, -increment, count);

  const View view = Look(fan, {0.1, 0.2, 0.3});
  const View reversed = Look(clockwise, {0.1, 0.2, 0.3});

  int hits = 0;
  for (int beam = 0; beam < count; ++beam) {
    const float range = view.ranges[beam];
    const float other = reversed.ranges[count - 1 - beam];
    if (std::isinf(range)) {
      ASSERT_EQ(other, range) << "beam " << beam;
    } else {
      ++hits;
      ASSERT_NEAR(other, range, 1e-4) << "beam " << beam;
    }
  }
  EXPECT_GT(hits, 300);
}

TEST_F(LidarTest, RefusesAPoseOrARangeThatIsNoNumber) {
  for (const Pose& pose : {Pose{kNaN, 0, 0}, Pose{0, kInfinity, 0}, Pose{0, 0, kNaN}}) {
    EXPECT_THROW(LookAhead(pose), std::invalid_argument);
  }
  for (double range : {0.0, -1.0, kNaN, kInfinity}) {
    settings_.range = range;
    EXPECT_THROW(LookAhead({}), std::invalid_argument) << range;
  }
}

TEST_F(LidarTest, RefusesOtherThreadsMeanwhile) {
  const World::Body body = AddBody({});
  const World::Joint joint = world_.AddRevolute(body, AddBody({}), {});
  const World::Drive drive = world_.AddDrive(body, {}, {});
  world_.AddLayer(RandomWalls(2000, 1.0), 0xFFFF);
  const BeamFan fan(0.0, 1e-6, 1000000);
  const std::pair<const char*, std::function<void()>> touches[] = {
      {"pose", [&] { world_.GetPose(body); }},
      {"joint", [&] { world_.GetJointAngle(joint); }},
      {"drive", [&] { world_.Get(drive); }},
  };

  for (const auto& [name, touch] : touches) {
    bool refused = false;
    // The scan may be over before this thread runs: then try again.
    for (int attempt = 0; attempt < 100 && !refused; ++attempt) {
      std::future<View> scan = std::async(std::launch::async, [&] { return Look(fan, {}); });
      while (!refused && scan.wait_for(std::chrono::seconds(0)) != std::future_status::ready) {
        try {
          touch();
        } catch (const std::logic_error&) {
          refused = true;
        }
      }
      scan.wait();
    }

    EXPECT_TRUE(refused) << name;
    EXPECT_NO_THROW(touch()) << name;
  }
}

TEST_F(LidarTest, SeesNoSensorsButWhatDoesNotCollide) {
  world_.AddPolygon(AddBody({2.5, 0, 0}), square_, Sensor());
  EXPECT_EQ(LookAhead({}), kInfinity);

  world_.AddPolygon(AddBody({4.5, 0, 0}), square_, Ghost());
  EXPECT_EQ(LookAhead({}), 4.0f);
}

TEST_F(LidarTest, SeesOnlyItsLayers) {
  world_.AddPolygon(AddBody({2.5, 0, 0}), square_, OnLayers(0b01));
  AddWallAt(5.0, 0b10);
  AddWallAt(7.0, 0b01);

  settings_.layers = 0b11;
  EXPECT_EQ(LookAhead({}), 2.0f);
  settings_.layers = 0b10;
  EXPECT_EQ(LookAhead({}), 5.0f);
  settings_.layers = 0b01;
  EXPECT_EQ(LookAhead({0, 4, 0}), 7.0f);
  settings_.layers = 0b100;
  EXPECT_EQ(LookAhead({}), kInfinity);
  settings_.layers = 0;
  EXPECT_EQ(LookAhead({}), kInfinity);
}

TEST_F(LidarTest, MeasuresTheIntensityOfTheNearestThing) {
  settings_.reflectance_layers = 0b10;
  const FixtureSettings dull = OnLayers(0b01), bright = OnLayers(0b10);
  AddWallAt(5.0, 0b10);
  AddWallAt(-5.0, 0b01);
  world_.AddPolygon(AddBody({0, 4, 0}), square_, bright);
  world_.AddPolygon(AddBody({3, 0, 0}), square_, dull);
  const auto intensity = [&](const Pose& lidar) {
    return Look(BeamFan(0.0, 0.0, 1), lidar).intensities[0];
  };

  EXPECT_EQ(intensity({0, -4, 0}), 255.0f) << "bright wall";
  EXPECT_EQ(intensity({0, 0, M_PI}), 0.0f) << "dull wall";
  EXPECT_EQ(intensity({0, 0, M_PI / 2}), 255.0f) << "bright body";
  EXPECT_EQ(intensity({0, 0, 0}), 0.0f) << "dull body before a bright wall";
  EXPECT_EQ(intensity({0, 0, -M_PI / 2}), 0.0f) << "nothing";
}

TEST_F(LidarTest, SeesWhatReflectsOnAWallOfTheSamePlace) {
  settings_.reflectance_layers = 0b10;
  AddWallAt(5.0, 0b01);
  world_.AddLayer({{{5, -1}, {5, 1}}}, 0b10);
  const Pose at_an_angle{0.123, 0.321, 0.02};

  const View view = Look(forward_, at_an_angle);

  for (int beam = 0; beam < forward_.size(); ++beam) {
    const double angle = at_an_angle.yaw - 0.75 * M_PI + beam * 1.5 * M_PI / 1080;
    if (std::abs(angle) > 1.4) continue;
    const double y = at_an_angle.y + std::tan(angle) * (5.0 - at_an_angle.x);
    if (std::abs(std::abs(y) - 1.0) < 1e-4) continue;
    ASSERT_EQ(view.intensities[beam], std::abs(y) < 1.0 ? 255.0f : 0.0f) << "beam " << beam;
  }
}

TEST_F(LidarTest, SeesNoIntensityBeyondItsRange) {
  settings_.reflectance_layers = 0b10;
  settings_.range = 5.0;
  AddWallAt(5.0 * (1.0 + 5e-10), 0b10);

  const View view = Look(BeamFan(0.0, 0.0, 1), {});

  EXPECT_EQ(view.ranges[0], kInfinity);
  EXPECT_EQ(view.intensities[0], 0.0f);
  AddWallAt(5.0, 0b01);
  EXPECT_EQ(LookAhead({}), 5.0f) << "at its very range, and dull";
}

TEST_F(LidarTest, MeasuresTheIntensityOfWhatIsAMillimetreNearer) {
  settings_.reflectance_layers = 0b10;
  AddWallAt(5.0, 0b01);
  AddWallAt(5.001, 0b10);
  AddWallAt(-5.001, 0b01);
  AddWallAt(-5.0, 0b10);

  EXPECT_EQ(Look(BeamFan(0.0, 0.0, 1), {}).intensities[0], 0.0f);
  EXPECT_EQ(Look(BeamFan(M_PI, 0.0, 1), {}).intensities[0], 255.0f);
}

TEST_F(LidarTest, IsIndependentOfTheScanBefore) {
  AddWallAt(2.0, 0b01);
  AddWallAt(-4.0, 0b10);
  settings_.reflectance_layers = 0b10;
  LookAhead({});
  settings_.reflectance_layers = 0;

  const View view = Look(BeamFan(0.0, 0.0, 1), {0, 0, M_PI});

  EXPECT_EQ(view.ranges[0], 4.0f);
  EXPECT_EQ(view.intensities[0], 0.0f);
}

}  // namespace
}  // namespace flatland
