/// Ranges do not depend on what a lidar has seen last.

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <vector>

#include "reference_walls.hpp"
#include "sight/depth_buffer.hpp"
#include "test_rounds.hpp"

namespace flatland {
namespace {

constexpr double kRange = 12.0;

class SeenWallsTest : public testing::TestWithParam<bool> {
 protected:
  const std::vector<Segment> walls_ = GetParam() ? PixelWalls(40, 25) : RandomWalls(3000, 0.7);
  const SegmentTree tree_{walls_};
  const BeamFan fan_{-M_PI, 2.0 * M_PI / 90, 90};
  std::mt19937 random_{29};
  SeenWalls seen_;

  std::vector<float> Scan(const Pose& pose, SeenWalls* seen) {
    DepthBuffer buffer;
    buffer.Begin(fan_, kRange);
    buffer.Draw(tree_, pose, seen);
    std::vector<float> ranges(fan_.size());
    buffer.GetRanges(ranges.data());
    return ranges;
  }
  /// A scan with what was seen last is that without it, and that of all walls.
  void ExpectTheSame(const Pose& pose) {
    const std::vector<float> ranges = Scan(pose, &seen_);
    ASSERT_EQ(ranges, Scan(pose, nullptr));
    for (int beam = 0; beam < fan_.size(); beam += 7) {
      const Vec2 direction = Rotation(pose.yaw).Apply(fan_.direction(beam));
      const double least = TryEveryWall(walls_, {pose.x, pose.y}, direction, 1e-8);
      const double most = TryEveryWall(walls_, {pose.x, pose.y}, direction, -1e-8);
      if (std::isinf(ranges[beam])) {
        ASSERT_GT(most, kRange - 1e-5);
      } else {
        ASSERT_GT(ranges[beam], least - 1e-5);
        ASSERT_LT(ranges[beam], most + 1e-5);
      }
    }
  }
  Pose RandomPose() {
    const Vec2 at = RandomPoint(random_, {-1, -1}, {21, 11});
    return {at.x, at.y, std::uniform_real_distribution<double>(-4, 4)(random_)};
  }
};

TEST_P(SeenWallsTest, DriveAndJump) {
  Pose pose = RandomPose();
  for (int i = 0; i < Rounds(1000); ++i) {
    if (random_() % 16 == 0) {
      pose = RandomPose();
    } else {
      const Vec2 way = RandomPoint(random_, {-0.3, -0.3}, {0.3, 0.3});
      pose = {pose.x + way.x, pose.y + way.y, pose.yaw + way.x};
    }
    ASSERT_NO_FATAL_FAILURE(ExpectTheSame(pose)) << i;
  }
}

TEST_P(SeenWallsTest, OfOtherWallsOrNone) {
  for (int i = 0; i < Rounds(300); ++i) {
    const Pose pose = RandomPose();
    seen_.place = {pose.x, pose.y};
    seen_.count = static_cast<int>(random_() % (SeenWalls::kMost + 1));
    const uint32_t first = static_cast<uint32_t>(random_());
    for (int k = 0; k < seen_.count; ++k) {
      const auto all = static_cast<uint32_t>(walls_.size());
      seen_.walls[k] = i % 3 == 0 ? first + k : (first % all + k) % all;
    }
    ASSERT_NO_FATAL_FAILURE(ExpectTheSame(pose)) << i;
  }
}

TEST_P(SeenWallsTest, AreKeptWhereALidarStays) {
  const Pose pose{10.4, 5.3, 0.0};
  Scan(pose, &seen_);
  Scan(pose, &seen_);
  const int count = seen_.count;
  ASSERT_GT(count, 0);
  Scan(pose, &seen_);
  EXPECT_EQ(seen_.count, count);
  EXPECT_LT(count, static_cast<int>(walls_.size()) / 4);
}

INSTANTIATE_TEST_SUITE_P(Walls, SeenWallsTest, testing::Bool(),
                         [](const auto& info) { return info.param ? "Pixels" : "Random"; });

}  // namespace
}  // namespace flatland
