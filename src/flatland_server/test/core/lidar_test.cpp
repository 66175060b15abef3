#include "flatland_server/lidar.hpp"

#include <gtest/gtest.h>

#include <atomic>
#include <future>
#include <memory>
#include <set>
#include <stdexcept>
#include <thread>
#include <vector>

#include "flatland_server/parallel.hpp"
#include "flatland_server/world.hpp"

namespace flatland {
namespace {

class LidarOnABody : public testing::Test {
 protected:
  LidarOnABody() {
    world_.AddLayer({{{0, 0}, {10, 0}}, {{10, 0}, {10, 6}}, {{10, 6}, {0, 6}}, {{0, 6}, {0, 0}}},
                    0xFFFF);
  }

  World::Body AddRobot(const Pose& pose) {
    BodySettings settings;
    settings.pose = pose;
    const World::Body body = world_.AddBody(settings);
    world_.AddCircle(body, {0, 0}, 0.2, {});
    return body;
  }

  World::LidarHandle AddLidar(World::Body body) {
    return world_.AddLidar(body, {fan_, mount_, {20.0, 0xFFFF, 0}});
  }

  // What a scan from the lidar's place says.
  std::vector<float> Expected(World::Body body) {
    const Pose at = world_.GetPose(body);
    const Vec2 place = Vec2{at.x, at.y} + Rotation(at.yaw).Apply({mount_.x, mount_.y});
    std::vector<float> ranges(fan_->size()), intensities(fan_->size());
    world_.Scan(*fan_, {place.x, place.y, at.yaw + mount_.yaw}, {20.0, 0xFFFF, 0}, ranges.data(),
                intensities.data());
    return ranges;
  }

  World world_{10, 10};
  const Pose mount_{0.3, -0.1, 0.5};
  std::shared_ptr<const BeamFan> fan_ = std::make_shared<BeamFan>(-2.0, 0.01, 401);
};

TEST_F(LidarOnABody, SeesWhatIsSeenFromItsPlace) {
  const World::Body robot = AddRobot({3, 2, 1.2});
  AddRobot({5, 3, 0});

  EXPECT_EQ(world_.Scan(AddLidar(robot)).ranges, Expected(robot));
}

TEST_F(LidarOnABody, SeesTheSameTogetherAsAlone) {
  std::vector<World::Body> robots;
  std::vector<World::LidarHandle> lidars;
  for (int i = 0; i < 40; ++i) {
    robots.push_back(AddRobot({0.5 + 0.22 * i, 1.0 + 0.1 * i, 0.3 * i}));
    lidars.push_back(AddLidar(robots.back()));
  }
  for (int step = 0; step < 5; ++step) {
    for (const auto& lidar : lidars) world_.ExpectScan(lidar);
    for (size_t i = 0; i < robots.size(); ++i) {
      ASSERT_EQ(world_.Scan(lidars[i]).ranges, Expected(robots[i])) << "robot " << i;
    }
    world_.SetVelocity(robots[step], {1.0, 0.5, 2.0});
    world_.Step(0.1);
  }
}

TEST_F(LidarOnABody, SeesWhatHasChangedSinceTheOthersHaveScanned) {
  const World::Body robot = AddRobot({3, 2, 0});
  const World::LidarHandle first = AddLidar(AddRobot({1, 1, 0}));
  const World::LidarHandle second = AddLidar(robot);
  world_.ExpectScan(first);
  world_.ExpectScan(second);
  const std::vector<float> before = world_.Scan(first).ranges;

  world_.SetPose(robot, {4, 3, 1});
  EXPECT_EQ(world_.Scan(second).ranges, Expected(robot));
  EXPECT_NE(world_.Scan(first).ranges, before) << "the robot stands elsewhere";

  const World::Body box = AddRobot({5, 3, 0});
  EXPECT_EQ(world_.Scan(second).ranges, Expected(robot)) << "something has come";
  world_.RemoveBody(box);
  EXPECT_EQ(world_.Scan(second).ranges, Expected(robot)) << "something has gone";
  world_.AddLayer({{{4.5, 0}, {4.5, 6}}}, 0xFFFF);
  EXPECT_EQ(world_.Scan(second).ranges, Expected(robot)) << "a wall has been put up";
}

TEST_F(LidarOnABody, GoesWithItsBody) {
  const World::Body robot = AddRobot({3, 2, 0});
  const World::LidarHandle lidar = AddLidar(robot);
  const World::LidarHandle other = AddLidar(AddRobot({1, 1, 0}));
  world_.ExpectScan(lidar);

  world_.RemoveBody(robot);

  EXPECT_THROW(world_.Scan(lidar), GoneError);
  EXPECT_THROW(world_.ExpectScan(lidar), GoneError);
  EXPECT_NO_THROW(world_.Scan(other));
}

TEST_F(LidarOnABody, RefusesWhatIsNoLidar) {
  const World::Body robot = AddRobot({3, 2, 0});

  EXPECT_THROW(world_.AddLidar(robot, {nullptr, {}, {20.0, 1, 0}}), std::invalid_argument);
  EXPECT_THROW(world_.AddLidar(robot, {fan_, {}, {0.0, 1, 0}}), std::invalid_argument);
  EXPECT_THROW(world_.AddLidar(robot, {fan_, {std::nan(""), 0, 0}, {20.0, 1, 0}}),
               std::invalid_argument);
}

TEST(ForEachInParallel, DoesEachPieceOnce) {
  for (int count : {0, 1, 3, 4, 5, 100, 1000}) {
    std::vector<std::atomic<int>> done(count);
    ForEachInParallel(count, [&](int i) { ++done[i]; });
    for (int i = 0; i < count; ++i) ASSERT_EQ(done[i], 1) << i << " of " << count;
  }
}

TEST(ForEachInParallel, ServesSeveralAtATime) {
  const auto run = [] {
    for (int round = 0; round < 200; ++round) {
      std::atomic<int> sum{0};
      ForEachInParallel(20, [&](int i) { sum += i; });
      if (sum != 190) return false;
    }
    return true;
  };
  std::vector<std::future<bool>> threads;
  for (int i = 0; i < 4; ++i) threads.push_back(std::async(std::launch::async, run));

  for (auto& thread : threads) EXPECT_TRUE(thread.get());
}

// Those that wait for each other are done at a time, if there is more than one core.
TEST(ForEachInParallel, UsesAnotherThread) {
  if (std::thread::hardware_concurrency() < 2) GTEST_SKIP() << "there is one core only";
  std::atomic<int> arrived{0};

  ForEachInParallel(8, [&](int) {
    ++arrived;
    while (arrived < 2) std::this_thread::yield();
  });

  EXPECT_EQ(arrived, 8);
}

}  // namespace
}  // namespace flatland
