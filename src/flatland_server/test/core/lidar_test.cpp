#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstdlib>
#include <future>
#include <memory>
#include <set>
#include <stdexcept>
#include <thread>
#include <vector>

#include "base/parallel.hpp"
#include "sight/lidars.hpp"
#include "test_bodies.hpp"
#include "world/world.hpp"

namespace flatland {
namespace {

class LidarOnABody : public WorldTest {
 protected:
  LidarOnABody() {
    world_.AddLayer({{{0, 0}, {10, 0}}, {{10, 0}, {10, 6}}, {{10, 6}, {0, 6}}, {{0, 6}, {0, 0}}},
                    0xFFFF);
  }

  World::Body AddRobot(const Pose& pose) { return AddDisc(world_, pose, 0.2, {}); }

  World::LidarHandle AddLidar(World::Body body) {
    return world_.lidars().Add(body, {fan_, mount_, {20.0, 0xFFFF, 0}});
  }

  // The ranges of a scan from the lidar's pose.
  std::vector<float> Expected(World::Body body) {
    const Pose at = world_.GetPose(body);
    const Vec2 place = Vec2{at.x, at.y} + Rotation(at.yaw).Apply({mount_.x, mount_.y});
    std::vector<float> ranges(fan_->size()), intensities(fan_->size());
    world_.lidars().Scan(*fan_, {place.x, place.y, at.yaw + mount_.yaw}, {20.0, 0xFFFF, 0},
                         ranges.data(), intensities.data());
    return ranges;
  }

  const Pose mount_{0.3, -0.1, 0.5};
  std::shared_ptr<const BeamFan> fan_ = std::make_shared<BeamFan>(-2.0, 0.01, 401);
};

TEST_F(LidarOnABody, SeesWhatIsSeenFromItsPlace) {
  const World::Body robot = AddRobot({3, 2, 1.2});
  AddRobot({5, 3, 0});

  EXPECT_EQ(world_.lidars().Scan(AddLidar(robot)).ranges, Expected(robot));
}

TEST_F(LidarOnABody, HasIntensitiesIfThereAreReflectanceLayers) {
  const World::Body robot = AddRobot({3, 2, 1.2});
  const World::LidarHandle reflecting =
      world_.lidars().Add(robot, {fan_, mount_, {20.0, 0xFFFF, 0b10}});

  EXPECT_EQ(world_.lidars().Scan(AddLidar(robot)).intensities.size(), 0u);
  EXPECT_EQ(world_.lidars().Scan(reflecting).intensities, std::vector<float>(fan_->size(), 255.0f));
}

TEST_F(LidarOnABody, SeesTheSameTogetherAsAlone) {
  std::vector<World::Body> robots;
  std::vector<World::LidarHandle> lidars;
  for (int i = 0; i < 40; ++i) {
    robots.push_back(AddRobot({0.5 + 0.22 * i, 1.0 + 0.1 * i, 0.3 * i}));
    lidars.push_back(AddLidar(robots.back()));
  }
  for (int step = 0; step < 5; ++step) {
    for (const auto& lidar : lidars) world_.lidars().Expect(lidar);
    for (size_t i = 0; i < robots.size(); ++i) {
      ASSERT_EQ(world_.lidars().Scan(lidars[i]).ranges, Expected(robots[i])) << "robot " << i;
    }
    world_.SetVelocity(robots[step], {1.0, 0.5, 2.0});
    world_.Step(0.1);
  }
}

// All expected lidars scan together with the requested one; the others do not.
TEST_F(LidarOnABody, ScansTogetherWithAllThatAreExpected) {
  std::vector<World::LidarHandle> lidars;
  for (int i = 0; i < 3; ++i) lidars.push_back(AddLidar(AddRobot({3.0 + i, 3, 0})));
  const Lidar* const asked = &world_.lidars().Scan(lidars[0]);
  const Lidar* const expected = &world_.lidars().Scan(lidars[1]);
  const Lidar* const other = &world_.lidars().Scan(lidars[2]);

  for (int step = 0; step < 3; ++step) {
    world_.Step(0.1);
    const uint64_t before = other->scanned_revision;
    world_.lidars().Expect(lidars[1]);
    world_.lidars().Expect(lidars[1]);
    world_.lidars().Scan(lidars[0]);
    EXPECT_GT(asked->scanned_revision, before);
    EXPECT_EQ(expected->scanned_revision, asked->scanned_revision) << "step " << step;
    EXPECT_EQ(other->scanned_revision, before);

    world_.Step(0.1);
    world_.lidars().Scan(lidars[0]);
    EXPECT_LT(expected->scanned_revision, asked->scanned_revision) << "it is expected no more";
    world_.lidars().Scan(lidars[2]);
  }
}

TEST_F(LidarOnABody, SeesWhatHasChangedSinceTheOthersHaveScanned) {
  const World::Body robot = AddRobot({3, 2, 0});
  const World::LidarHandle first = AddLidar(AddRobot({1, 1, 0}));
  const World::LidarHandle second = AddLidar(robot);
  world_.lidars().Expect(first);
  world_.lidars().Expect(second);
  const std::vector<float> before = world_.lidars().Scan(first).ranges;

  world_.SetPose(robot, {4, 3, 1});
  const std::vector<float> seen =
      world_.lidars().Scan(second).ranges;  // before anything else scans
  EXPECT_EQ(seen, Expected(robot));
  EXPECT_NE(world_.lidars().Scan(first).ranges, before) << "the robot stands elsewhere";

  const World::Body box = AddRobot({5, 3, 0});
  EXPECT_EQ(world_.lidars().Scan(second).ranges, Expected(robot)) << "something has come";
  world_.RemoveBody(box);
  EXPECT_EQ(world_.lidars().Scan(second).ranges, Expected(robot)) << "something has gone";
  world_.AddLayer({{{4.5, 0}, {4.5, 6}}}, 0xFFFF);
  EXPECT_EQ(world_.lidars().Scan(second).ranges, Expected(robot)) << "a wall has been put up";
}

TEST_F(LidarOnABody, SeesStaticBodiesWhereTheyAre) {
  const World::LidarHandle lidar = AddLidar(AddRobot({3, 2, 0}));
  const auto scan = [&] { return world_.lidars().Scan(lidar).ranges; };
  const std::vector<float> without = scan();
  const World::Body pillar = AddPost(world_, {6, 3, 0});
  world_.AddCircle(pillar, {0, 0}, 0.4, {});
  const std::vector<float> with = scan();
  EXPECT_NE(with, without);
  world_.Step(0.1);
  EXPECT_EQ(scan(), with);

  world_.SetPose(pillar, {5, 2, 0});
  const std::vector<float> nearer = scan();
  EXPECT_NE(nearer, with);
  world_.SetPose(pillar, {6, 3, 0});
  EXPECT_EQ(scan(), with);

  TweenSettings tween;
  tween.delta = {-1, -1, 0};
  tween.duration = 0.1;
  world_.AddTween(pillar, tween);
  world_.Step(0.1);
  EXPECT_EQ(scan(), nearer);
  world_.RemoveBody(pillar);
  EXPECT_EQ(scan(), without);
}

TEST_F(LidarOnABody, GoesWithItsBody) {
  const World::Body robot = AddRobot({3, 2, 0});
  const World::LidarHandle lidar = AddLidar(robot);
  const World::LidarHandle other = AddLidar(AddRobot({1, 1, 0}));
  world_.lidars().Scan(AddLidar(robot));
  world_.lidars().Expect(lidar);

  world_.RemoveBody(robot);

  EXPECT_THROW(world_.lidars().Scan(lidar), GoneError);
  EXPECT_THROW(world_.lidars().Expect(lidar), GoneError);
  EXPECT_NO_THROW(world_.lidars().Scan(other));
}

TEST_F(LidarOnABody, RefusesInvalidSettings) {
  const World::Body robot = AddRobot({3, 2, 0});

  EXPECT_THROW(world_.lidars().Add(robot, {nullptr, {}, {20.0, 1, 0}}), std::invalid_argument);
  EXPECT_THROW(world_.lidars().Add(robot, {fan_, {}, {0.0, 1, 0}}), std::invalid_argument);
  EXPECT_THROW(world_.lidars().Add(robot, {fan_, {std::nan(""), 0, 0}, {20.0, 1, 0}}),
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

TEST(ForEachInParallel, WaitsForAllPieces) {
  const std::thread::id here = std::this_thread::get_id();
  for (int round = 0; round < 20; ++round) {
    std::atomic<int> done{0};
    ForEachInParallel(8, [&](int) {
      const bool is_slow = std::this_thread::get_id() != here;
      std::this_thread::sleep_for(std::chrono::milliseconds(is_slow ? 5 : 1));
      ++done;
    });
    ASSERT_EQ(done, 8);
  }
}

// True if two pieces are done at a time: each waits for the other, but not for ever.
bool UsesSeveralThreads() {
  const auto limit = std::chrono::steady_clock::now() + std::chrono::seconds(20);
  std::atomic<int> arrived{0};
  ForEachInParallel(8, [&](int) {
    ++arrived;
    while (arrived < 2 && std::chrono::steady_clock::now() < limit) std::this_thread::yield();
  });
  return std::chrono::steady_clock::now() < limit;
}

TEST(ForEachInParallel, UsesAnotherThread) {
  if (std::thread::hardware_concurrency() < 2) GTEST_SKIP() << "there is one core only";

  EXPECT_TRUE(UsesSeveralThreads());
}

TEST(ForEachInParallel, StartsThreadsOfItsOwnInAChildProcess) {
  if (std::thread::hardware_concurrency() < 2) GTEST_SKIP() << "there is one core only";
  ForEachInParallel(8, [](int) {});

  const pid_t child = fork();
  if (child == 0) std::_Exit(UsesSeveralThreads() ? 0 : 1);

  int status = 0;
  ASSERT_EQ(waitpid(child, &status, 0), child);
  EXPECT_TRUE(WIFEXITED(status) && WEXITSTATUS(status) == 0);
}

}  // namespace
}  // namespace flatland
