#include <box2d/box2d.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <functional>
#include <future>
#include <limits>
#include <memory>
#include <optional>
#include <random>
#include <stdexcept>
#include <utility>
#include <vector>

#include "flatland_server/depth_buffer.hpp"
#include "flatland_server/mover.hpp"
#include "flatland_server/segment_tree.hpp"
#include "flatland_server/world.hpp"

namespace flatland {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
constexpr double kFar = 1e6;

Vec2 Towards(double angle) { return {std::cos(angle), std::sin(angle)}; }

Vec2 RandomPoint(std::mt19937& random, Vec2 low, Vec2 high) {
  return {std::uniform_real_distribution<double>(low.x, high.x)(random),
          std::uniform_real_distribution<double>(low.y, high.y)(random)};
}

Vec2 RandomDirection(std::mt19937& random) {
  return Towards(std::uniform_real_distribution<double>(-M_PI, M_PI)(random));
}

// The nearest hit by trying every wall, made longer at both ends by `longer` times its length.
double TryEveryWall(const std::vector<Segment>& walls, Vec2 origin, Vec2 direction, double longer) {
  double nearest = kInfinity;
  for (const Segment& wall : walls) {
    // How far the wall's ends lie to the left of the ray.
    const double left_a = Cross(direction, wall.a - origin);
    const double left_b = Cross(direction, wall.b - origin);
    if (left_a == left_b) continue;
    const double part = left_a / (left_a - left_b);
    if (part < -longer || part > 1.0 + longer) continue;
    const double ahead =
        Dot(direction, wall.a - origin) * (1.0 - part) + Dot(direction, wall.b - origin) * part;
    if (ahead >= 0.0) nearest = std::min(nearest, ahead);
  }
  return nearest;
}

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

// A ray past the very end of a wall may stop there or go on; anywhere else there is one answer.
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
  for (int i = 0; i < rays; ++i) {
    const Vec2 origin = RandomPoint(random, low, high);
    ASSERT_NO_FATAL_FAILURE(ExpectAsTryingEveryWall(walls, tree, origin, RandomDirection(random)));
    for (const Vec2 axis : {Vec2{1, 0}, Vec2{0, 1}, Vec2{-1, 0}, Vec2{0, -1}}) {
      ASSERT_NO_FATAL_FAILURE(ExpectAsTryingEveryWall(walls, tree, origin, axis));
    }
  }
}

std::vector<Segment> RandomWalls(int count, double longest) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> length(0.01, longest);
  std::vector<Segment> walls;
  for (int i = 0; i < count; ++i) {
    const Vec2 a = RandomPoint(random, {0, 0}, {20, 10});
    const Vec2 direction = RandomDirection(random);
    const double l = length(random);
    walls.push_back({a, {a.x + l * direction.x, a.y + l * direction.y}});
  }
  return walls;
}

// The outlines of random unit pixels, as a map's loader makes them: a wall along every border
// between black and white.
std::vector<Segment> PixelWalls(int columns, int rows) {
  std::mt19937 random(3);
  std::vector<std::vector<bool>> black(columns + 2, std::vector<bool>(rows + 2, false));
  for (int x = 1; x <= columns; ++x) {
    for (int y = 1; y <= rows; ++y) black[x][y] = random() % 5 == 0;
  }
  std::vector<Segment> walls;
  for (int x = 0; x <= columns; ++x) {
    for (int y = 0; y <= rows; ++y) {
      const double left = x, bottom = y, right = x + 1, top = y + 1;
      if (black[x][y] != black[x + 1][y]) walls.push_back({{right, bottom}, {right, top}});
      if (black[x][y] != black[x][y + 1]) walls.push_back({{left, top}, {right, top}});
    }
  }
  return walls;
}

TEST(SegmentTree, SeesRandomWalls) {
  ExpectAsTryingEveryWall(RandomWalls(400, 2.0), {-1, -1}, {21, 11}, 3000);
}

TEST(SegmentTree, SeesLongRandomWalls) {
  ExpectAsTryingEveryWall(RandomWalls(100, 15.0), {-10, -10}, {30, 20}, 3000);
}

TEST(SegmentTree, SeesAFewSparseWalls) {
  ExpectAsTryingEveryWall(RandomWalls(5, 0.5), {-1, -1}, {21, 11}, 3000);
}

TEST(SegmentTree, SeesThePixelsOfAMap) {
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
  for (int i = 0; i < 4000; ++i) {
    const Vec2 origin = RandomPoint(random, {-500, -500}, {500, 500});
    const Vec2 goal = RandomPoint(random, {-5, -5}, {25, 15});
    const Vec2 way = goal - origin;
    const double length = std::hypot(way.x, way.y);
    const Vec2 direction{way.x / length, way.y / length};
    ASSERT_NO_FATAL_FAILURE(ExpectAsTryingEveryWall(walls, tree, origin, direction));
    if (Cast(tree, origin, direction, kFar) < kInfinity) ++hits;
  }
  EXPECT_GT(hits, 1000);
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

TEST(SegmentTree, SeesFromThePlacesOfARegularGrid) {
  const std::vector<Segment> walls = PixelWalls(40, 25);
  const SegmentTree tree(walls);
  Vec2 low{kFar, kFar}, high{-kFar, -kFar};
  for (const Segment& wall : walls) {
    low = {std::min(low.x, wall.a.x), std::min(low.y, wall.a.y)};
    high = {std::max(high.x, wall.b.x), std::max(high.y, wall.b.y)};
  }
  low = low - Vec2{1e-6, 1e-6};
  high = high + Vec2{1e-6, 1e-6};
  const double cell = std::sqrt((high.x - low.x) * (high.y - low.y) / walls.size());

  for (int i = 0; low.x + i * cell < high.x; ++i) {
    for (int j = 0; low.y + j * cell < high.y; ++j) {
      const Vec2 corner{low.x + i * cell, low.y + j * cell};
      for (int eighth = 0; eighth < 8; ++eighth) {
        const Vec2 direction = Towards(eighth * M_PI / 4);
        ASSERT_NO_FATAL_FAILURE(ExpectAsTryingEveryWall(walls, tree, corner, direction));
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

  buffer.Begin(fan, kFar);
  buffer.Draw(SegmentTree(std::vector<Segment>{{{-5, hair}, {-5, 3}}}), {});
  buffer.GetRanges(ranges);
  EXPECT_EQ(ranges[0], 5.0f) << "the wall is on the left, the beam on the right";

  buffer.Begin(fan, kFar);
  buffer.Draw(SegmentTree(std::vector<Segment>{{{-5, -hair}, {-5, -3}}}), {});
  buffer.GetRanges(ranges);
  EXPECT_EQ(ranges[7], 5.0f) << "the wall is on the right, the beam on the left";
}

TEST(SegmentTree, SeesNothingBeyondTheLimit) {
  const SegmentTree tree(std::vector<Segment>{{{5, -1}, {5, 1}}});

  EXPECT_EQ(Cast(tree, {0, 0}, {1, 0}, 6.0), 5.0);
  EXPECT_EQ(Cast(tree, {0, 0}, {1, 0}, 5.0), 5.0);
  EXPECT_EQ(Cast(tree, {0, 0}, {1, 0}, 4.999), kInfinity);
  EXPECT_EQ(Cast(tree, {0, 0}, {1, 0}, 0.0), kInfinity);
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

TEST(SegmentTree, SeesNothingBehind) {
  const SegmentTree tree(std::vector<Segment>{{{5, -1}, {5, 1}}});

  EXPECT_EQ(Cast(tree, {6, 0}, {1, 0}, kFar), kInfinity);
  EXPECT_EQ(Cast(tree, {0, 0}, {-1, 0}, kFar), kInfinity);
}

// Walls are drawn on several beams at a time, and passed over where nearer ones are there already.
void ExpectEachBeamAsIfAlone(const std::vector<Segment>& walls, const BeamFan& fan, Vec2 low,
                             Vec2 high) {
  const SegmentTree tree(walls);
  std::mt19937 random(23);
  DepthBuffer buffer;
  std::vector<float> ranges(fan.size());
  for (int i = 0; i < 30; ++i) {
    const Vec2 at = RandomPoint(random, low, high);
    const double yaw = std::uniform_real_distribution<double>(-4, 4)(random);
    buffer.Begin(fan, 12.0);
    buffer.Draw(tree, {at.x, at.y, yaw});
    buffer.GetRanges(ranges.data());
    for (int beam = 0; beam < fan.size(); ++beam) {
      const Vec2 direction = Rotation(yaw).Apply(fan.direction(beam));
      const double least = TryEveryWall(walls, at, direction, 1e-8);
      const double most = TryEveryWall(walls, at, direction, -1e-8);
      if (ranges[beam] == kInfinity) {
        ASSERT_GT(most, 12.0 - 1e-5) << "beam " << beam << " of scan " << i;
      } else {
        ASSERT_GT(ranges[beam], least - 1e-5) << "beam " << beam << " of scan " << i;
        ASSERT_LT(ranges[beam], most + 1e-5) << "beam " << beam << " of scan " << i;
      }
    }
  }
}

struct NamedFan {
  const char* name;
  BeamFan fan;
};

class WholeFan : public testing::TestWithParam<NamedFan> {};

TEST_P(WholeFan, SeesRandomWalls) {
  ExpectEachBeamAsIfAlone(RandomWalls(400, 2.0), GetParam().fan, {-1, -1}, {21, 11});
}

TEST_P(WholeFan, SeesThePixelsOfAMap) {
  ExpectEachBeamAsIfAlone(PixelWalls(40, 25), GetParam().fan, {-2, -2}, {44, 29});
}

TEST_P(WholeFan, SeesFromTheCornersOfPixels) {
  const std::vector<Segment> walls = PixelWalls(12, 9);
  const SegmentTree tree(walls);
  DepthBuffer buffer;
  std::vector<float> ranges(GetParam().fan.size());
  for (double x = 0; x < 14; ++x) {
    for (double y = 0; y < 11; ++y) {
      const bool touches = TryEveryWall(walls, {x, y}, {0.6, 0.8}, 0.0) == 0.0;
      buffer.Begin(GetParam().fan, 50.0);
      buffer.Draw(tree, {x, y, 0.1});
      buffer.GetRanges(ranges.data());
      for (float range : ranges) ASSERT_EQ(range == 0.0f, touches) << x << ", " << y;
    }
  }
}

INSTANTIATE_TEST_SUITE_P(
    Fans, WholeFan,
    testing::Values(NamedFan{"three_quarters", {-0.75 * M_PI, 1.5 * M_PI / 400, 401}},
                    NamedFan{"clockwise", {0.75 * M_PI, -1.5 * M_PI / 400, 401}},
                    NamedFan{"full_turn", {0.0, 2.0 * M_PI / 360, 360}},
                    NamedFan{"two_turns", {-M_PI, 4.0 * M_PI / 300, 301}},
                    NamedFan{"coarse", {0.3, 1.1, 7}}, NamedFan{"single", {2.0, 0.0, 1}}),
    [](const testing::TestParamInfo<NamedFan>& info) { return info.param.name; });

TEST(SegmentTree, IsNoDeeperThanItMayBe) {
  std::vector<Segment> walls;
  for (int i = 0; i < 4000; ++i) walls.push_back({{3, -1}, {3, 1}});
  // Each next gap is half as wide: one cut after the other separates a single wall from the rest.
  for (double x = 4.0; x > 1e-290; x *= 0.5) walls.push_back({{x, -1}, {x, 1}});
  const SegmentTree tree(walls);

  int most = 0;
  const std::function<void(const SegmentTree::Child&, int)> descend =
      [&](const SegmentTree::Child& child, int depth) {
        most = std::max(most, depth);
        if (child.is_leaf()) return;
        for (const auto& each : tree.node(child).children) descend(each, depth + 1);
      };
  descend(tree.root(), 0);

  EXPECT_LE(most, SegmentTree::kMostDepth);
  EXPECT_EQ(Cast(tree, {2.5, 0}, {1, 0}, kFar), 0.5);
  EXPECT_EQ(Cast(tree, {1.5, 0}, {-1, 0}, kFar), 0.5);
}

TEST(SegmentTree, IsSharedByThoseWithTheSameWalls) {
  const auto first = SegmentTree::Share(PixelWalls(5, 5));
  const auto other = SegmentTree::Share(PixelWalls(5, 6));

  EXPECT_EQ(SegmentTree::Share(PixelWalls(5, 5)), first);
  EXPECT_NE(first, other);

  const std::weak_ptr<const SegmentTree> gone = SegmentTree::Share(PixelWalls(6, 5));
  EXPECT_TRUE(gone.expired()) << "nobody uses it any more";
}

TEST(SegmentTree, IsEmptyWithoutWalls) {
  const SegmentTree tree(std::vector<Segment>{});

  EXPECT_EQ(tree.segment_count(), 0u);
  EXPECT_EQ(Cast(tree, {0, 0}, {1, 0}, kFar), kInfinity);
  EXPECT_EQ(Cast(tree, {-3, 2}, Towards(-0.5), kFar), kInfinity);
}

struct View {
  std::vector<float> ranges;
  std::vector<float> intensities;
};

class LidarTest : public testing::Test {
 protected:
  LidarTest() { settings_.range = 30.0; }

  View Look(const BeamFan& fan, const Pose& pose) const {
    View view{std::vector<float>(fan.size(), -1.0f), std::vector<float>(fan.size(), -1.0f)};
    world_.Scan(fan, pose, settings_, view.ranges.data(), view.intensities.data());
    return view;
  }

  // The range of a single beam along the lidar's x axis.
  float LookAhead(const Pose& pose) const { return Look(BeamFan(0.0, 0.0, 1), pose).ranges[0]; }

  World::Body AddBody(const Pose& pose) {
    BodySettings settings;
    settings.pose = pose;
    return world_.AddBody(settings);
  }

  void AddWallAt(double x, LayerBits layers = 0xFFFF) {
    world_.AddLayer({{{x, -20}, {x, 20}}}, layers);
  }

  World world_{10, 10};
  ScanSettings settings_;
  const std::vector<Vec2> square_{{-0.5, -0.5}, {0.5, -0.5}, {0.5, 0.5}, {-0.5, 0.5}};
  const BeamFan forward_{-0.75 * M_PI, 1.5 * M_PI / 1080, 1081};
};

TEST_F(LidarTest, MeasuresARoom) {
  world_.AddLayer({{{0, 0}, {10, 0}}, {{10, 0}, {10, 6}}, {{10, 6}, {0, 6}}, {{0, 6}, {0, 0}}},
                  0xFFFF);
  const Pose lidar{3.3, 1.7, 0.4};

  const View view = Look(forward_, lidar);

  for (int beam = 0; beam < forward_.size(); ++beam) {
    const Vec2 d = Towards(lidar.yaw + (-0.75 * M_PI + beam * 1.5 * M_PI / 1080));
    const double across = d.x > 0 ? (10 - lidar.x) / d.x : -lidar.x / d.x;
    const double up = d.y > 0 ? (6 - lidar.y) / d.y : -lidar.y / d.y;
    ASSERT_NEAR(view.ranges[beam], std::min(across, up), 1e-4) << "beam " << beam;
    ASSERT_EQ(view.intensities[beam], 0.0f);
  }
}

TEST_F(LidarTest, SaysInfinityWhereNothingIsInRange) {
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
  EXPECT_NEAR(LookAhead({0, 0, 0.9}), 3.0 / std::cos(0.9), 1e-4);
  EXPECT_EQ(LookAhead({0, 0, 0.95}), kInfinity);
  EXPECT_EQ(LookAhead({0, 0, -1.2}), kInfinity);
}

TEST_F(LidarTest, SeesACircleAtItsVeryRange) {
  world_.AddCircle(AddBody({4, 0, 0}), {0, 0}, 1.0, {});
  settings_.range = 3.0;

  EXPECT_EQ(LookAhead({}), 3.0f);
}

// Each corner of a shape in turn, far out, while all else is out of range.
TEST_F(LidarTest, SeesTheTipOfABody) {
  settings_.range = 2.0;
  for (int quarter = 0; quarter < 4; ++quarter) {
    const Rotation turn(quarter * M_PI / 2);
    const World::Body body = AddBody({5, 0, M_PI - quarter * M_PI / 2});
    world_.AddPolygon(body, {turn.Apply({3.1, 0}), turn.Apply({0, 0.2}), turn.Apply({0, -0.2})},
                      {});

    EXPECT_NEAR(LookAhead({}), 1.9, 1e-5) << quarter << " quarter turns";
    world_.RemoveBody(body);
  }
}

TEST_F(LidarTest, MeasuresACircle) {
  const World::Body body = AddBody({2.0, 1.0, 0.5});
  const Rotation turn(0.5);
  const Vec2 center = Vec2{2.0, 1.0} + turn.Apply({0.3, -0.2});
  world_.AddCircle(body, {0.3, -0.2}, 0.6, {});

  const View view = Look(forward_, {-1.0, 0.5, 0.2});

  int hits = 0;
  for (int beam = 0; beam < forward_.size(); ++beam) {
    const double angle = 0.2 + (-0.75 * M_PI + beam * 1.5 * M_PI / 1080);
    const Vec2 way = center - Vec2{-1.0, 0.5};
    const double across = Cross(Towards(angle), way);
    const double along = Dot(Towards(angle), way);
    if (std::abs(std::abs(across) - 0.6) < 1e-4) continue;  // grazing
    const bool hit = along > 0.0 && std::abs(across) < 0.6;
    const double expected = hit ? along - std::sqrt(0.36 - across * across) : kInfinity;
    if (hit) {
      ++hits;
      ASSERT_NEAR(view.ranges[beam], expected, 1e-4) << "beam " << beam;
    } else {
      ASSERT_EQ(view.ranges[beam], kInfinity) << "beam " << beam;
    }
  }
  EXPECT_GT(hits, 50);
}

TEST_F(LidarTest, MeasuresAPolygon) {
  // A square on its tip: its near corner 2 m ahead.
  const World::Body body = AddBody({2.0 + std::sqrt(0.5), 0.0, M_PI / 4});
  world_.AddPolygon(body, square_, {});

  const View view = Look(forward_, {});

  const double far_left = std::atan2(std::sqrt(0.5), 2.0 + std::sqrt(0.5));
  for (int beam = 0; beam < forward_.size(); ++beam) {
    const double angle = std::abs((-0.75 * M_PI + beam * 1.5 * M_PI / 1080));
    if (std::abs(angle - far_left) < 1e-4) continue;  // grazing
    if (angle < far_left) {
      // Its near sides are the lines x = 2 + |y|.
      const double expected = 2.0 / (std::cos(angle) - std::sin(angle));
      ASSERT_NEAR(view.ranges[beam], expected, 1e-4) << "beam " << beam;
    } else {
      ASSERT_EQ(view.ranges[beam], kInfinity) << "beam " << beam;
    }
  }
}

TEST_F(LidarTest, LooksOutOfACircleAroundIt) {
  const World::Body body = AddBody({0.1, 0.0, 0.0});
  world_.AddCircle(body, {0, 0}, 0.5, {});
  AddWallAt(3.0);
  world_.AddCircle(AddBody({0.0, 4.0, 0.0}), {0, 0}, 1.0, {});

  EXPECT_EQ(LookAhead({}), 3.0f);
  EXPECT_NEAR(LookAhead({0, 0, M_PI / 2}), 3.0, 1e-5);
  EXPECT_EQ(LookAhead({0, 0, M_PI}), kInfinity);
}

TEST_F(LidarTest, LooksOutOfAPolygonAroundIt) {
  const World::Body body = AddBody({0.1, 0.0, 0.3});
  world_.AddPolygon(body, square_, {});
  AddWallAt(3.0);
  world_.AddPolygon(AddBody({0.0, 4.0, 0.0}), square_, {});

  EXPECT_EQ(LookAhead({}), 3.0f);
  EXPECT_NEAR(LookAhead({0, 0, M_PI / 2}), 3.5, 1e-5);
  EXPECT_EQ(LookAhead({0, 0, M_PI}), kInfinity);
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

TEST_F(LidarTest, SeesNoSensors) {
  FixtureSettings sensor;
  sensor.sensor = true;
  world_.AddPolygon(AddBody({2.5, 0, 0}), square_, sensor);

  EXPECT_EQ(LookAhead({}), kInfinity);
}

TEST_F(LidarTest, SeesNothingInvisible) {
  FixtureSettings invisible;
  invisible.visible = false;
  world_.AddPolygon(AddBody({2.5, 0, 0}), square_, invisible);

  EXPECT_EQ(LookAhead({}), kInfinity);
}

TEST_F(LidarTest, SeesWhatDoesNotCollide) {
  FixtureSettings ghost;
  ghost.collides = false;
  world_.AddPolygon(AddBody({2.5, 0, 0}), square_, ghost);

  EXPECT_EQ(LookAhead({}), 2.0f);
}

TEST_F(LidarTest, SeesOnlyItsLayers) {
  FixtureSettings high;
  high.layers = 0b01;
  world_.AddPolygon(AddBody({2.5, 0, 0}), square_, high);
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

TEST_F(LidarTest, SaysTheIntensityOfTheNearestThing) {
  settings_.reflectance_layers = 0b10;
  FixtureSettings dull, bright;
  dull.layers = 0b01;
  bright.layers = 0b10;
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
}

TEST_F(LidarTest, SeesADullWallAtItsVeryRangeBesideWhatReflects) {
  settings_.reflectance_layers = 0b10;
  settings_.range = 5.0;
  AddWallAt(5.0, 0b01);

  EXPECT_EQ(LookAhead({}), 5.0f);
}

TEST_F(LidarTest, SaysTheIntensityOfWhatIsAMillimetreNearer) {
  settings_.reflectance_layers = 0b10;
  AddWallAt(5.0, 0b01);
  AddWallAt(5.001, 0b10);
  AddWallAt(-5.001, 0b01);
  AddWallAt(-5.0, 0b10);

  EXPECT_EQ(Look(BeamFan(0.0, 0.0, 1), {}).intensities[0], 0.0f);
  EXPECT_EQ(Look(BeamFan(M_PI, 0.0, 1), {}).intensities[0], 255.0f);
}

TEST_F(LidarTest, ForgetsWhatAnotherOneHasSeen) {
  AddWallAt(2.0, 0b01);
  AddWallAt(-4.0, 0b10);
  settings_.reflectance_layers = 0b10;
  LookAhead({});
  settings_.reflectance_layers = 0;

  const View view = Look(BeamFan(0.0, 0.0, 1), {0, 0, M_PI});

  EXPECT_EQ(view.ranges[0], 4.0f);
  EXPECT_EQ(view.intensities[0], 0.0f);
}

// A body of which either side looks out from behind a wall.
TEST_F(LidarTest, SeesTheSideOfACircleThatAWallLeavesFree) {
  for (double side : {-1.0, 1.0}) {
    World world(10, 10);
    world.AddLayer({{{2, -0.1 * side}, {2, 5 * side}}}, 0xFFFF);
    BodySettings settings;
    settings.pose = {4, 0, 0};
    world.AddCircle(world.AddBody(settings), {0, 0}, 1.0, {});
    float range, intensity;
    world.Scan(BeamFan(-0.2 * side, 0.0, 1), {}, settings_, &range, &intensity);

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

TEST_F(LidarTest, LetsNobodyElseInMeanwhile) {
  const World::Body body = AddBody({});
  const World::Joint joint = world_.AddRevolute(body, AddBody({}), {});
  const World::Drive drive = world_.AddDrive(body, {}, {});
  world_.AddLayer(RandomWalls(2000, 1.0), 0xFFFF);
  const BeamFan fan(0.0, 1e-6, 1000000);
  const std::pair<const char*, std::function<void()>> touches[] = {
      {"pose", [&] { world_.GetPose(body); }},
      {"joint", [&] { world_.JointAngle(joint); }},
      {"drive", [&] { world_.Get(drive); }},
  };

  for (const auto& [name, touch] : touches) {
    bool refused = false;
    // The scan may be over before this thread gets its turn: then once more.
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

// Box2D's own answer; nothing where it depends on a hair's breadth.
std::optional<double> AskBox2D(const b2Fixture& fixture, const Pose& lidar, double angle) {
  double distances[3];
  for (int i = 0; i < 3; ++i) {
    const Vec2 direction = Towards(lidar.yaw + angle + (i - 1) * 1e-3);
    b2RayCastInput ray;
    ray.p1 = {static_cast<float>(lidar.x), static_cast<float>(lidar.y)};
    ray.p2 = ray.p1 + b2Vec2{static_cast<float>(direction.x), static_cast<float>(direction.y)};
    ray.maxFraction = 100.0f;
    b2RayCastOutput hit;
    const b2Transform& place = fixture.GetBody()->GetTransform();
    const bool is_hit = fixture.GetShape()->RayCast(&hit, ray, place, 0);
    distances[i] = is_hit ? hit.fraction : kInfinity;
  }
  const auto [low, high] = std::minmax({distances[0], distances[1], distances[2]});
  if (low == kInfinity) return kInfinity;
  if (high - low > 0.02) return std::nullopt;
  return distances[1];
}

void ExpectAsBox2D(const b2Fixture& fixture, std::mt19937& random) {
  const Vec2 at = RandomPoint(random, {-3, -3}, {3, 3});
  const Pose lidar{at.x, at.y, std::uniform_real_distribution<double>(-3, 3)(random)};
  const BeamFan fan(-3.14, 0.02, 315);
  DepthBuffer buffer;
  buffer.Begin(fan, 100.0);
  const Mover mover(fixture, ReachOf(*fixture.GetShape()));
  Discs discs;
  discs.Add(mover.middle, mover.reach);
  const std::vector<int> seen = buffer.FindSeen(discs, lidar);
  mover.DrawOn(buffer, at, Rotation(lidar.yaw));
  std::vector<float> ranges(fan.size());
  buffer.GetRanges(ranges.data());
  for (int beam = 0; beam < fan.size(); ++beam) {
    const double angle = -3.14 + beam * 0.02;
    const std::optional<double> expected = AskBox2D(fixture, lidar, angle);
    if (!expected) continue;
    const double distance = ranges[beam];
    if (*expected == kInfinity) {
      ASSERT_EQ(distance, kInfinity) << "towards " << angle;
      continue;
    }
    ASSERT_NEAR(distance, *expected, 1e-4) << "towards " << angle;
    ASSERT_EQ(seen.size(), 1u) << "what is hit must be looked at";
  }
}

TEST(DepthBuffer, SeesNoPolygonNearerThanItIsAlongItsSide) {
  std::mt19937 random(29);
  DepthBuffer buffer;
  for (int i = 0; i < 3000; ++i) {
    const Rotation turn(std::uniform_real_distribution<double>(-3, 3)(random));
    const double near = 0.05 * (1 + random() % 100), far = near + 0.05 * (1 + random() % 100);
    const double side = i % 2 == 0 ? 1.0 : -1.0;
    Vec2 corners[] = {{near, 0}, {far, 0}, {0.5 * (near + far), side}};
    if (side < 0.0) std::swap(corners[0], corners[1]);
    for (Vec2& corner : corners) corner = turn.Apply(corner);
    const BeamFan fan(std::vector<Vec2>{turn.Apply({1, 0})});
    float range;
    buffer.Begin(fan, kFar);
    buffer.DrawPolygon(corners, 3);
    buffer.GetRanges(&range);
    ASSERT_GT(range, 0.999 * near) << "polygon " << i;
  }
}

// Box2D can lose a body that is too light for what pushes it.
TEST(DepthBuffer, SeesNothingOfWhatIsAtNoNumber) {
  const BeamFan fan(-3.0, 0.01, 601);
  const Vec2 corners[] = {{1, 0}, {kNaN, kNaN}, {kNaN, kNaN}};
  Discs discs;
  discs.Add({kNaN, kNaN}, 1.0);
  discs.Add({3, 0}, 1.0);
  DepthBuffer buffer;
  buffer.Begin(fan, 10.0);
  buffer.FindSeen(discs, {});
  buffer.DrawCircle({kNaN, kNaN}, 1.0);
  buffer.DrawPolygon(corners, 3);

  std::vector<float> ranges(fan.size());
  buffer.GetRanges(ranges.data());
  for (float range : ranges) EXPECT_EQ(range, kInfinity);
}

class MoverTest : public testing::Test {
 protected:
  b2Body& AddBody() {
    b2BodyDef definition;
    const Vec2 at = RandomPoint(random_, {-2, -2}, {2, 2});
    definition.position = {static_cast<float>(at.x), static_cast<float>(at.y)};
    definition.angle = std::uniform_real_distribution<float>(-3, 3)(random_);
    return *world_.CreateBody(&definition);
  }

  b2World world_{b2Vec2_zero};
  std::mt19937 random_{17};
};

TEST_F(MoverTest, CastsAtPolygonsAsBox2DDoes) {
  for (int i = 0; i < 300; ++i) {
    std::vector<b2Vec2> corners(3 + i % 6);
    for (b2Vec2& corner : corners) {
      const Vec2 at = RandomPoint(random_, {-1, -1}, {1, 1});
      corner = {static_cast<float>(at.x), static_cast<float>(at.y)};
    }
    b2PolygonShape polygon;
    polygon.Set(corners.data(), static_cast<int32>(corners.size()));

    ASSERT_NO_FATAL_FAILURE(ExpectAsBox2D(*AddBody().CreateFixture(&polygon, 0.0f), random_))
        << "polygon " << i;
  }
}

TEST_F(MoverTest, CastsAtCirclesAsBox2DDoes) {
  for (int i = 0; i < 300; ++i) {
    b2CircleShape circle;
    const Vec2 at = RandomPoint(random_, {-1, -1}, {1, 1});
    circle.m_p = {static_cast<float>(at.x), static_cast<float>(at.y)};
    circle.m_radius = std::uniform_real_distribution<float>(0.05f, 1.5f)(random_);

    ASSERT_NO_FATAL_FAILURE(ExpectAsBox2D(*AddBody().CreateFixture(&circle, 0.0f), random_))
        << "circle " << i;
  }
}

}  // namespace
}  // namespace flatland
