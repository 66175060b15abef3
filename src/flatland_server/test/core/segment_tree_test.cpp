/// Walls in a tree, along one beam, compared with a test of every wall.

#include "sight/segment_tree.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <random>
#include <vector>

#include "reference_walls.hpp"
#include "sight/beam_fan.hpp"
#include "sight/depth_buffer.hpp"
#include "test_rounds.hpp"

namespace flatland {
namespace {

// The distance to the nearest wall along one beam; +infinity beyond the limit. In single precision.
double Cast(const SegmentTree& walls, Vec2 origin, Vec2 direction, double limit) {
  const BeamFan fan(std::vector<Vec2>{direction});
  DepthBuffer buffer;
  buffer.Begin(fan, limit);
  buffer.Draw(walls, {origin.x, origin.y, 0.0});
  float range;
  buffer.GetRanges(&range);
  return range;
}

// At the very end of a wall a ray may hit it or miss it; anywhere else the result is unambiguous.
void ExpectAsTryingEveryWall(const std::vector<Segment>& walls, const SegmentTree& tree,
                             Vec2 origin, Vec2 direction) {
  const double with_longer_walls = TryEveryWall(walls, origin, direction, 1e-8);
  const double with_shorter_walls = TryEveryWall(walls, origin, direction, -1e-8);
  const double distance = Cast(tree, origin, direction, kFar);

  const double rounding = 1e-7 * std::max(1.0, std::min(with_longer_walls, 1e4));
  const bool right =
      with_longer_walls <= distance + rounding && distance <= with_shorter_walls + rounding;
  ASSERT_TRUE(right) << distance << " m instead of " << with_longer_walls << " to "
                     << with_shorter_walls << " from (" << origin.x << ", " << origin.y
                     << ") towards (" << direction.x << ", " << direction.y << ")";
}

void ExpectAsTryingEveryWall(const std::vector<Segment>& walls, Vec2 low, Vec2 high, int rays) {
  const SegmentTree tree(walls);
  std::mt19937 random(42);
  for (int i = 0; i < Rounds(rays); ++i) {
    const Vec2 origin = RandomPoint(random, low, high);
    ASSERT_NO_FATAL_FAILURE(ExpectAsTryingEveryWall(walls, tree, origin, RandomDirection(random)));
    for (const Vec2 axis : {Vec2{1, 0}, Vec2{0, 1}, Vec2{-1, 0}, Vec2{0, -1}}) {
      ASSERT_NO_FATAL_FAILURE(ExpectAsTryingEveryWall(walls, tree, origin, axis));
    }
  }
}

TEST(SegmentTree, SeesWalls) {
  ExpectAsTryingEveryWall(RandomWalls(400, 2.0), {-1, -1}, {21, 11}, 3000);
  ExpectAsTryingEveryWall(RandomWalls(100, 15.0), {-10, -10}, {30, 20}, 3000);  // long ones
  ExpectAsTryingEveryWall(RandomWalls(5, 0.5), {-1, -1}, {21, 11}, 3000);       // few
  ExpectAsTryingEveryWall(PixelWalls(40, 25), {-2, -2}, {44, 29}, 3000);
}

TEST(SegmentTree, SeesASingleWallOfAnyDirection) {
  for (const Vec2 end : {Vec2{5, 1}, Vec2{1, 5}, Vec2{5, 5}, Vec2{-3, 5}, Vec2{1 + 1e-9, 5}}) {
    SCOPED_TRACE(testing::Message() << "from (1, 1) to (" << end.x << ", " << end.y << ")");
    ExpectAsTryingEveryWall({{{1, 1}, end}}, {-4, -2}, {7, 7}, 2000);
  }
}

TEST(SegmentTree, SeesCentimetreWallsBesideOneOfTenKilometres) {
  std::vector<Segment> walls = RandomWalls(300, 0.02);
  walls.push_back({{-5000, -1}, {5000, 12.5}});

  ExpectAsTryingEveryWall(walls, {-1, -3}, {21, 13}, 3000);
  ExpectAsTryingEveryWall(walls, {-6000, -3}, {6000, 13}, 2000);
}

TEST(SegmentTree, SeesItsWallsFromFarOutside) {
  const std::vector<Segment> walls = RandomWalls(400, 2.0);
  const SegmentTree tree(walls);
  std::mt19937 random(5);

  int hits = 0;
  for (int i = 0; i < Rounds(4000); ++i) {
    const Vec2 origin = RandomPoint(random, {-500, -500}, {500, 500});
    const Vec2 goal = RandomPoint(random, {-5, -5}, {25, 15});
    const Vec2 way = goal - origin;
    const double length = std::hypot(way.x, way.y);
    const Vec2 direction{way.x / length, way.y / length};
    ASSERT_NO_FATAL_FAILURE(ExpectAsTryingEveryWall(walls, tree, origin, direction));
    if (Cast(tree, origin, direction, kFar) < kInfinity) ++hits;
  }
  EXPECT_GT(hits, Rounds(1000));
}

// On whole and half numbers the arithmetic is exact, so the answers must be the very same. A ray
// that runs along a wall does not see it, but stops where a wall crosses or touches it.
TEST(SegmentTree, IsExactForRaysAlongTheLinesOfAMap) {
  const std::vector<Segment> walls = PixelWalls(40, 25);
  const SegmentTree tree(walls);

  for (double x = -1.0; x <= 43.0; x += 0.5) {
    for (double y = -1.0; y <= 28.0; y += 0.5) {
      for (const Vec2 axis : {Vec2{1, 0}, Vec2{0, 1}, Vec2{-1, 0}, Vec2{0, -1}}) {
        ASSERT_EQ(Cast(tree, {x, y}, axis, kFar), TryEveryWall(walls, {x, y}, axis, 0.0))
            << "from (" << x << ", " << y << ") towards (" << axis.x << ", " << axis.y << ")";
      }
    }
  }
}

TEST(SegmentTree, LetsNoRayOutThroughACorner) {
  std::mt19937 random(11);
  std::vector<Vec2> corners;
  for (int i = 0; i < 50; ++i) {
    const Vec2 out = Towards(i * 2.0 * M_PI / 50);
    corners.push_back({1.0 + 4.0 * out.x, 2.0 + 4.0 * out.y});
  }
  std::vector<Segment> round_room;
  for (int i = 0; i < 50; ++i) round_room.push_back({corners[i], corners[(i + 1) % 50]});
  const SegmentTree tree(round_room);

  for (int i = 0; i < 4000; ++i) {
    const Vec2 origin = RandomPoint(random, {-1, 0}, {3, 4});
    const Vec2 way = corners[i % 50] - origin;
    const double length = std::hypot(way.x, way.y);
    ASSERT_NEAR(Cast(tree, origin, {way.x / length, way.y / length}, kFar), length, 1e-6);
  }
}

TEST(SegmentTree, LetsNoRayThroughTheCornersOfPixels) {
  // A closed square of unit walls, seen from whole and half places: many rays run exactly through
  // the places where two walls meet.
  std::vector<Segment> walls;
  for (double i = 0; i < 8; ++i) {
    walls.push_back({{i, 0}, {i + 1, 0}});
    walls.push_back({{i, 8}, {i + 1, 8}});
    walls.push_back({{0, i}, {0, i + 1}});
    walls.push_back({{8, i}, {8, i + 1}});
  }
  const SegmentTree tree(walls);

  for (double x = 0.5; x < 8; x += 0.5) {
    for (double y = 0.5; y < 8; y += 0.5) {
      for (double along = 0; along <= 8; ++along) {
        const Vec2 way = Vec2{along, 8} - Vec2{x, y};
        const double length = std::hypot(way.x, way.y);
        ASSERT_NEAR(Cast(tree, {x, y}, {way.x / length, way.y / length}, kFar), length, 1e-6);
      }
    }
  }
}

// Turned, neither the wall nor the beam is exact any more. Whether a beam along a wall meets it is
// a matter of rounding; that it ends before the wall is not.
TEST(SegmentTree, SeesNoWallNearerThanItIsAlongIt) {
  std::mt19937 random(19);
  DepthBuffer buffer;
  for (int i = 0; i < 3000; ++i) {
    const double along = i % 8 * M_PI / 4,
                 yaw = std::uniform_real_distribution<double>(-3, 3)(random);
    const double near = 0.05 * (1 + random() % 100), far = near + 0.05 * (1 + random() % 100);
    const Vec2 at{0.05 * (random() % 200), 0.05 * (random() % 200)};
    const SegmentTree tree({{at + near * Towards(along), at + far * Towards(along)}});
    const BeamFan fan(std::vector<Vec2>{Towards(along - yaw)});
    float range;
    buffer.Begin(fan, kFar);
    buffer.Draw(tree, {at.x, at.y, yaw});
    buffer.GetRanges(&range);
    ASSERT_GT(range, 0.999 * near) << "at (" << at.x << ", " << at.y << "), turned by " << yaw;
  }
}

TEST(SegmentTree, EndsAllBeamsOfALidarOnAWall) {
  const BeamFan fan(0.1, 2.0 * M_PI / 50, 50);
  DepthBuffer buffer;
  std::vector<float> ranges(fan.size());
  for (const Segment& wall : {Segment{{0.3, 0.2}, {0.8, 0.2}}, Segment{{0.7, 5.1}, {0.7, -0.4}}}) {
    const Vec2 on_it = wall.a + 0.3 * (wall.b - wall.a);
    for (double yaw = -3.0; yaw < 3.0; yaw += 0.01) {
      buffer.Begin(fan, kFar);
      buffer.Draw(SegmentTree({wall}), {on_it.x, on_it.y, yaw});
      buffer.GetRanges(ranges.data());
      for (float range : ranges) ASSERT_EQ(range, 0.0f) << "turned by " << yaw;
    }
  }
}

// Straight behind, directions jump: a wall's end and a beam may lie on either side of that.
TEST(SegmentTree, StopsABeamAtTheVeryEndOfAWallStraightBehind) {
  const double hair = 1e-20;
  const BeamFan fan({{-1, -hair}, {0, -1}, {1, 0}, {1, 0}, {1, 0}, {1, 0}, {0, 1}, {-1, 0}});
  float ranges[8];
  DepthBuffer buffer;
  for (const double side : {1.0, -1.0}) {  // of the wall; the beam is on the other one
    buffer.Begin(fan, kFar);
    buffer.Draw(SegmentTree(std::vector<Segment>{{{-5, side * hair}, {-5, side * 3}}}), {});
    buffer.GetRanges(ranges);
    EXPECT_EQ(ranges[side > 0.0 ? 0 : 7], 5.0f) << side;
  }
}

TEST(SegmentTree, SeesNothingBeyondTheLimitBehindAndWithoutWalls) {
  const SegmentTree tree(std::vector<Segment>{{{5, -1}, {5, 1}}}), empty(std::vector<Segment>{});

  EXPECT_EQ(Cast(tree, {0, 0}, {1, 0}, 6.0), 5.0);
  EXPECT_EQ(Cast(tree, {0, 0}, {1, 0}, 5.0), 5.0);
  EXPECT_EQ(Cast(tree, {0, 0}, {1, 0}, 4.999), kInfinity);
  EXPECT_EQ(Cast(tree, {0, 0}, {1, 0}, 0.0), kInfinity);
  EXPECT_EQ(Cast(tree, {6, 0}, {1, 0}, kFar), kInfinity);
  EXPECT_EQ(Cast(tree, {0, 0}, {-1, 0}, kFar), kInfinity);
  EXPECT_EQ(empty.segment_count(), 0u);
  EXPECT_EQ(Cast(empty, {-3, 2}, Towards(-0.5), kFar), kInfinity);
}

TEST(SegmentTree, SeesNothingBeyondTheLimitWithinOneCell) {
  const std::vector<Segment> walls = RandomWalls(400, 2.0);
  const SegmentTree tree(walls);
  std::mt19937 random(13);

  for (int i = 0; i < 3000; ++i) {
    const Vec2 origin = RandomPoint(random, {0, 0}, {20, 10});
    const Vec2 direction = RandomDirection(random);
    const double distance = Cast(tree, origin, direction, kFar);
    if (distance == kInfinity) continue;
    ASSERT_EQ(Cast(tree, origin, direction, 1.001 * distance), distance);
    ASSERT_EQ(Cast(tree, origin, direction, 0.999 * distance), kInfinity);
  }
}

TEST(SegmentTree, IsNoDeeperWithWallsInOnePlaceOrEverNearer) {
  std::vector<Segment> walls;
  for (int i = 0; i < 4000; ++i) walls.push_back({{3, -1}, {3, 1}});
  for (double x = 4.0; x > 1e-290; x *= 0.5) walls.push_back({{x, -1}, {x, 1}});
  const SegmentTree tree(walls);

  EXPECT_EQ(tree.leaf_count(), (walls.size() + 7) / 8);
  EXPECT_EQ(tree.levels().size(), 3u);
  EXPECT_EQ(Cast(tree, {2.5, 0}, {1, 0}, kFar), 0.5);
  EXPECT_EQ(Cast(tree, {1.5, 0}, {-1, 0}, kFar), 0.5);
}

TEST(SegmentTree, HasEachWallInTheLeavesThatItsBoxMeets) {
  for (const int count : {1, 7, 8, 9, 64, 65, 513, 3000}) {
    const std::vector<Segment> walls = RandomWalls(count, 2.0);
    const SegmentTree tree(walls);
    for (uint32_t wall = 0; wall < walls.size(); ++wall) {
      Box box;
      box.Add(walls[wall]);
      int found = 0;
      tree.ForEachLeafAt(box, [&](size_t leaf) {
        tree.ForEachWall(leaf, [&](uint32_t index) { found += index == wall ? 1 : 0; });
      });
      ASSERT_EQ(found, 1) << "wall " << wall << " of " << count;
    }
    const Box room{{8, 4}, {9, 5}};
    const auto distance = [&](uint32_t index) {
      Box box;
      box.Add(walls[index]);
      return box.Distance(room);
    };
    double least = kFar;
    for (uint32_t wall = 0; wall < walls.size(); ++wall) least = std::min(least, distance(wall));
    EXPECT_EQ(tree.Least(room, kFar, distance), least);
  }
}

}  // namespace
}  // namespace flatland
