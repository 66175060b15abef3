/// The walls and bodies that people avoid.

#include "people/obstacles.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

namespace flatland {
namespace {

constexpr double kReach = 3.0;

/// The walls seen from a point.
std::vector<Obstacle> Around(const std::vector<Segment>& walls, Vec2 point,
                             LayerBits layers = kAllLayers) {
  b2World world(b2Vec2_zero);
  Bodies bodies;
  Layers all(bodies, 1.0f);
  all.Add(world, walls, 1, {});
  std::vector<Obstacle> found, seen;
  SeeWalls(all, layers, point, kReach, found, seen);
  return seen;
}

void ExpectSeen(const Obstacle& seen, double gap, double away) {
  EXPECT_NEAR(seen.gap, gap, 1e-9);
  EXPECT_NEAR(seen.away.x, std::cos(away), 1e-9);
  EXPECT_NEAR(seen.away.y, std::sin(away), 1e-9);
}

const std::vector<Segment> kCorridor{{{-9, 1}, {9, 1}}, {{-9, -0.5}, {9, -0.5}}};

TEST(ObstaclesTest, AWallIsSeenOnceHoweverManyPiecesItHas) {
  for (const int pieces : {1, 7, 1000}) {
    std::vector<Segment> wall;
    for (int i = 0; i < pieces; ++i) {
      wall.push_back({{20.0 * i / pieces - 10.0, 2.0}, {20.0 * (i + 1) / pieces - 10.0, 2.0}});
    }
    const std::vector<Obstacle> seen = Around(wall, {0.3, 1.0});
    ASSERT_EQ(seen.size(), 1u);
    ExpectSeen(seen[0], 1.0, -M_PI / 2);
  }
}

TEST(ObstaclesTest, BothWallsOfACorridorOrACornerAndBothEndsOfADoorwayAreSeen) {
  std::vector<Obstacle> seen = Around(kCorridor, {3, 0});
  ASSERT_EQ(seen.size(), 2u);
  ExpectSeen(seen[0], 0.5, M_PI / 2);
  ExpectSeen(seen[1], 1.0, -M_PI / 2);

  seen = Around({{{0, 0}, {9, 0}}, {{0, 0}, {0, 9}}}, {0.4, 0.6});
  ASSERT_EQ(seen.size(), 2u);
  ExpectSeen(seen[0], 0.4, 0.0);
  ExpectSeen(seen[1], 0.6, M_PI / 2);

  seen = Around({{{0, -9}, {0, -0.5}}, {{0, 0.5}, {0, 9}}}, {-0.3, 0.1});
  ASSERT_EQ(seen.size(), 2u);
  ExpectSeen(seen[0], 0.5, std::atan2(-0.4, -0.3));
  ExpectSeen(seen[1], std::hypot(0.3, 0.6), std::atan2(0.6, -0.3));
}

TEST(ObstaclesTest, NoWallIsSeenBeyondTheReachOrOnOtherLayers) {
  EXPECT_TRUE(Around({}, {1, 2}).empty());
  EXPECT_TRUE(Around(kCorridor, {3, 1 + kReach + 0.01}).empty());
  EXPECT_EQ(Around(kCorridor, {3, 1 + kReach - 0.01}).size(), 1u);
  EXPECT_TRUE(Around(kCorridor, {3, 0}, 2).empty());
}

TEST(ObstaclesTest, OnAWallThereIsNoDirectionAway) {
  const std::vector<Obstacle> seen = Around(kCorridor, {1, 1});
  ASSERT_EQ(seen.size(), 2u);
  EXPECT_EQ(seen[0].gap, 0.0);
  EXPECT_EQ(LengthOf(seen[0].away), 0.0);
  ExpectSeen(seen[1], 1.5, M_PI / 2);
}

TEST(ObstaclesTest, ThePointOfABodyThatIsNearest) {
  b2CircleShape disc;
  disc.m_p.Set(2.0f, 0.0f);
  disc.m_radius = 0.5f;
  b2PolygonShape box;
  box.SetAsBox(1.0f, 0.5f);
  Outline outline;
  outline.shapes = {&disc, &box};
  const Rotation heading(M_PI / 2);  // the disc is above the box
  ExpectSeen(outline.SeenFrom({10, 6}, {10, 0}, heading), 3.5, M_PI / 2);
  ExpectSeen(outline.SeenFrom({12, 0.25}, {10, 0}, heading), 1.5, 0.0);
  ExpectSeen(outline.SeenFrom({9.2, -1.4}, {10, 0}, heading), 0.5, std::atan2(-0.4, -0.3));
}

}  // namespace
}  // namespace flatland
