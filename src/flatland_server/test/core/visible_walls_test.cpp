/// No wall that can be seen from a box is left out, and most of the others are.

#include "sight/visible_walls.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <string>
#include <vector>

#include "reference_walls.hpp"
#include "sight/depth_buffer.hpp"
#include "sight/walls_seen_from.hpp"
#include "test_rounds.hpp"

namespace flatland {
namespace {

/// The sides of a polygon, each of several walls, which share their corners to the last bit.
void AddPolygon(std::vector<Segment>& walls, const std::vector<Vec2>& corners, int parts) {
  for (size_t i = 0; i < corners.size(); ++i) {
    const Vec2 from = corners[i], to = corners[(i + 1) % corners.size()];
    const auto at = [&](int k) {
      return k == parts ? to : from + static_cast<double>(k) / parts * (to - from);
    };
    for (int k = 0; k < parts; ++k) walls.push_back({at(k), at(k + 1)});
  }
}

/// A floor of 20 m by 10 m, with rounded pillars of many walls, some of which touch.
std::vector<Segment> Pillars() {
  std::mt19937 random(11);
  std::vector<Segment> walls;
  AddPolygon(walls, {{0, 0}, {20, 0}, {20, 10}, {0, 10}}, 40);
  for (int i = 0; i < 60; ++i) {
    const Vec2 center = RandomPoint(random, {0.5, 0.5}, {19.5, 9.5});
    const double radius = std::uniform_real_distribution<double>(0.1, 0.9)(random);
    const int count = 3 + static_cast<int>(random() % 14);
    std::vector<Vec2> corners;
    for (int k = 0; k < count; ++k) {
      corners.push_back(center + radius * Towards(2.0 * M_PI * k / count + center.x));
    }
    AddPolygon(walls, corners, 1 + static_cast<int>(random() % 3));
  }
  return walls;
}

/// A spiral of many turns around the middle of the floor, of walls that share corners.
std::vector<Segment> Spiral() {
  std::vector<Segment> walls;
  const auto at = [](int i) { return Vec2{10, 5} + 0.02 * i * Towards(0.25 * i); };
  for (int i = 1; i < 400; ++i) walls.push_back({at(i), at(i + 1)});
  return walls;
}

/// Each wall twice, and once more along half of it.
std::vector<Segment> Doubled(std::vector<Segment> walls) {
  for (size_t i = 0, count = walls.size(); i < count; ++i) {
    const auto [a, b] = walls[i];
    walls.push_back({b, a});
    walls.push_back({a, 0.5 * (a + b)});
  }
  return walls;
}

/// Rooms in a grid, with a door of 0.8 m in each side.
std::vector<Segment> Rooms() {
  std::vector<Segment> walls;
  for (int x = 0; x <= 20; x += 4) {
    for (int y = 0; y <= 10; y += 2) {
      const Vec2 at{static_cast<double>(x), static_cast<double>(y)};
      if (x < 20) {
        walls.push_back({at, {at.x + 1.2, at.y}});
        walls.push_back({{at.x + 2.0, at.y}, {at.x + 4.0, at.y}});
      }
      if (y < 10) {
        walls.push_back({at, {at.x, at.y + 0.5}});
        walls.push_back({{at.x, at.y + 1.3}, {at.x, at.y + 2.0}});
      }
    }
  }
  return walls;
}

struct Floor {
  std::string name;
  std::vector<Segment> walls;
  double most_seen;  // of all walls, on an average
};

class VisibleWallsTest : public testing::TestWithParam<Floor> {
 protected:
  const std::vector<Segment>& walls_ = GetParam().walls;
  const SegmentTree tree_{walls_};
  const Corners corners_{walls_};
  std::mt19937 random_{31};

  /// Every fourth is near the middle, where the spiral is.
  Vec2 RandomPlace() {
    const bool is_near = random_() % 4 == 0;
    return is_near ? RandomPoint(random_, {9.5, 4.5}, {10.5, 5.5})
                   : RandomPoint(random_, {-1, -1}, {21, 11});
  }
  double RandomPart() { return std::uniform_real_distribution<double>(0.0, 1.0)(random_); }
  static std::vector<float> Ranges(const DepthBuffer& buffer, const BeamFan& fan) {
    std::vector<float> ranges(fan.size());
    buffer.GetRanges(ranges.data());
    return ranges;
  }
  /// A scan of these walls alone is the scan of all, to the last bit.
  void ExpectTheSame(WallList only, Vec2 place, double range = 100.0) {
    const BeamFan fan(RandomPart(), 2.0 * M_PI / 720, 720);
    const Pose pose{place.x, place.y, 6.0 * RandomPart()};
    DepthBuffer some, all;
    some.Begin(fan, range);
    some.Draw(tree_, only, pose);
    all.Begin(fan, range);
    all.Draw(tree_, pose);
    ASSERT_EQ(Ranges(some, fan), Ranges(all, fan)) << place.x << ", " << place.y;
  }
};

TEST_P(VisibleWallsTest, ScansOfABoxAreThoseOfAllWalls) {
  for (int i = 0; i < Rounds(300); ++i) {
    const Vec2 corner = RandomPlace();
    const double size = std::pow(10.0, 2.5 * RandomPart() - 2.5);
    const Box box{corner, corner + size * Vec2{RandomPart(), 1.0}};
    const std::vector<uint32_t> only = WallsSeenFrom(tree_, corners_, box).value();
    for (const Vec2 place : {box.low, box.high, Vec2{box.low.x, box.high.y},
                             RandomPoint(random_, box.low, box.high)}) {
      ASSERT_NO_FATAL_FAILURE(ExpectTheSame({only.data(), only.size()}, place)) << size;
    }
  }
}

TEST_P(VisibleWallsTest, MostWallsAreLeftOut) {
  double seen = 0.0;
  constexpr int kPlaces = 50;
  for (int i = 0; i < kPlaces; ++i) {
    const Vec2 place = RandomPlace();
    const auto found = WallsSeenFrom(tree_, corners_, {place, place + Vec2{0.2, 0.2}})->size();
    seen += static_cast<double>(found) / static_cast<double>(walls_.size()) / kPlaces;
  }
  EXPECT_LT(seen, GetParam().most_seen);
}

TEST_P(VisibleWallsTest, AreKnownAfterSomeScansOfACell) {
  const VisibleWalls visible(walls_);
  int known = 0;
  size_t left_out = 0;
  for (int i = 0; i < Rounds(120); ++i) {
    const Vec2 place = RandomPlace();
    const void* cell = nullptr;
    for (int k = 1; k < VisibleWalls::kScansBefore; ++k) visible.From(place, 100.0, cell);
    const WallList found = visible.From(place, 100.0, cell);
    if (found.indices == nullptr) continue;
    ++known;
    ASSERT_NO_FATAL_FAILURE(ExpectTheSame(found, place));
    for (const double range : {0.3, 2.0, 3.0, 20.0 * RandomPart()}) {
      const WallList near = visible.From(place, range, cell);
      ASSERT_EQ(near.indices, found.indices);
      ASSERT_NO_FATAL_FAILURE(ExpectTheSame(near, place, range));
      left_out += found.count - near.count;
    }
  }
  EXPECT_GT(known, 0);
  EXPECT_GT(left_out, 0) << "walls beyond the range";
  const void* cell;
  EXPECT_EQ(visible.From({1e9, -1e9}, 100.0, cell).indices, nullptr);
  EXPECT_EQ(visible.From({NAN, 5.1}, 100.0, cell).indices, nullptr);
}

INSTANTIATE_TEST_SUITE_P(Walls, VisibleWallsTest,
                         testing::Values(Floor{"Pixels", PixelWalls(20, 10), 0.25},
                                         Floor{"Random", RandomWalls(3000, 0.7), 0.1},
                                         Floor{"Pillars", Pillars(), 0.2},
                                         Floor{"Spiral", Spiral(), 0.1},
                                         Floor{"Doubled", Doubled(Pillars()), 0.2},
                                         Floor{"Rooms", Rooms(), 0.4}),
                         [](const auto& info) { return info.param.name; });

TEST(VisibleWalls, IsSharedByThoseWithTheSameWalls) {
  const auto first = VisibleWalls::Share(PixelWalls(5, 5));
  const auto other = VisibleWalls::Share(PixelWalls(5, 6));

  EXPECT_EQ(VisibleWalls::Share(PixelWalls(5, 5)), first);
  EXPECT_NE(first, other);

  const std::weak_ptr<const VisibleWalls> gone = VisibleWalls::Share(PixelWalls(6, 5));
  EXPECT_TRUE(gone.expired()) << "it is not used any more";
}

TEST(VisibleWalls, WhatReceivesTheProgressCanMakeAnotherTree) {
  std::shared_ptr<const VisibleWalls> other;

  const auto tree = VisibleWalls::Share(
      PixelWalls(7, 5), [&](size_t) { other = VisibleWalls::Share(PixelWalls(7, 6)); });

  EXPECT_EQ(tree->all().segment_count(), PixelWalls(7, 5).size());
  ASSERT_NE(other, nullptr);
  EXPECT_EQ(other->all().segment_count(), PixelWalls(7, 6).size());
}

// As on a noisy map: each speck is a chain of its own, and the search would take minutes.
TEST(VisibleWalls, AreNotSearchedForAmongManySpecks) {
  std::mt19937 random(7);
  std::vector<Segment> walls;
  for (int i = 0; i < 10'000; ++i) {
    const Vec2 a = RandomPoint(random, {0, 0}, {20, 20}), b = a + Vec2{0.05, 0.05};
    walls.insert(walls.end(), {{a, {b.x, a.y}}, {{b.x, a.y}, b}, {b, {a.x, b.y}}, {{a.x, b.y}, a}});
  }
  EXPECT_FALSE(WallsSeenFrom(SegmentTree(walls), Corners(walls), {{10, 10}, {10.5, 10.5}}));
  const VisibleWalls visible(walls);
  const void* cell;
  for (int i = 0; i <= VisibleWalls::kScansBefore; ++i) {
    EXPECT_EQ(visible.From({10.2, 10.2}, 100.0, cell).indices, nullptr);
  }
}

TEST(VisibleWalls, OfNoWalls) {
  EXPECT_TRUE(WallsSeenFrom(SegmentTree({}), Corners({}), {{0, 0}, {1, 1}})->empty());
  const void* cell;
  EXPECT_EQ(VisibleWalls({}).From({0, 0}, 100.0, cell).indices, nullptr);
}

}  // namespace
}  // namespace flatland
