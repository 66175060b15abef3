/// VisibleWalls: fewer walls, the same scans.

#include "flatland_server/visible_walls.hpp"

#include <gtest/gtest.h>

#include <climits>
#include <cmath>
#include <random>
#include <thread>
#include <vector>

#include "../../src/core/wall_search.hpp"
#include "flatland_server/depth_buffer.hpp"
#include "test_rounds.hpp"

namespace flatland {
namespace {

class Dice {
 public:
  explicit Dice(int seed) : engine_(seed) {}
  double operator()(double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(engine_);
  }

 private:
  std::mt19937 engine_;
};

/// The outline of a rectangle.
void AddOutline(std::vector<Segment>& walls, Vec2 low, Vec2 high) {
  const Vec2 right{high.x, low.y}, left{low.x, high.y};
  for (const Segment& wall :
       {Segment{low, right}, Segment{right, high}, Segment{high, left}, Segment{left, low}}) {
    walls.push_back(wall);
  }
}

/// Pillars, blocks side by side and walls in all directions, in a hall.
std::vector<Segment> Hall(int seed) {
  Dice dice(seed);
  std::vector<Segment> walls;
  AddOutline(walls, {0, 0}, {20, 20});
  for (int i = 0; i < 40; ++i) {
    const Vec2 low{std::floor(dice(1, 18)), std::floor(dice(1, 18))};
    AddOutline(walls, low, low + Vec2{dice(0.1, 2), i % 2 == 0 ? 1.0 : dice(0.1, 1)});
    const Vec2 end{dice(0, 20), dice(0, 20)};
    walls.push_back({end, end + Vec2{dice(-2, 2), dice(-2, 2)}});
  }
  return walls;
}

/// A hall, and beside it four rooms without doors.
std::vector<Segment> HallAndRooms(int seed) {
  std::vector<Segment> walls = Hall(seed);
  for (int room = 0; room < 4; ++room) {
    const Vec2 low{21, 5.0 * room};
    AddOutline(walls, low, low + Vec2{4, 4});
    for (int i = 0; i < 9; ++i) {
      for (int k = 0; k < 9; ++k) {
        const Vec2 pillar = low + Vec2{0.3 + 0.4 * i, 0.3 + 0.4 * k};
        AddOutline(walls, pillar, pillar + Vec2{0.05, 0.05});
      }
    }
  }
  return walls;
}

template <class Walls>
std::vector<float> Scan(const BeamFan& fan, const Walls& walls, const Pose& pose) {
  DepthBuffer buffer;
  buffer.Begin(fan, 30.0);
  buffer.Draw(walls, pose);
  std::vector<float> ranges(fan.size());
  buffer.GetRanges(ranges.data());
  return ranges;
}

TEST(VisibleWallsTest, ScansAreTheSameFromEveryPointOfACell) {
  const BeamFan fan(-3.1, 0.01, 620);
  for (int seed = 0; seed < 4; ++seed) {
    Dice dice(100 + seed);
    const SegmentTree all(Hall(seed));
    for (int cell = 0; cell < Rounds(40); ++cell) {
      const Vec2 low{std::floor(dice(0, 20)), std::floor(dice(0, 20))};
      Box box;
      box.Add(Segment{low, low + Vec2{1, 1}});
      const WallList seen(all.segments(), WallsSeenFrom(all, box), low);
      for (int i = 0; i < 12; ++i) {
        // Some at the corners and on the edges of the cell, where walls are too.
        const double x = i < 4 ? i % 2 : dice(0, 1), y = i < 6 ? i / 2 % 2 : dice(0, 1);
        const Pose pose{low.x + x, low.y + y, i < 6 ? 0.0 : dice(-3, 3)};
        ASSERT_EQ(Scan(fan, seen, pose), Scan(fan, all, pose)) << seed << " " << cell << " " << i;
      }
    }
  }
}

TEST(VisibleWallsTest, WallsBehindOthersAreLeftOut) {
  std::vector<Segment> walls;
  AddOutline(walls, {0, 0}, {10, 10});
  walls.push_back({{4, 0}, {4, 10}});
  for (int i = 0; i < 20; ++i) AddOutline(walls, {7, 0.5 * i}, {7.2, 0.5 * i + 0.2});
  Box box;
  box.Add(Segment{{1, 4}, {2, 6}});
  const std::vector<uint32_t> seen = WallsSeenFrom(SegmentTree(walls), box);
  EXPECT_EQ(seen.size(), 4u);  // that wall, and those of the outline but the right one
  EXPECT_TRUE(WallsSeenFrom(SegmentTree({}), box).empty());
}

TEST(VisibleWallsTest, WallsThatTurnTheirBackAreLeftOut) {
  std::vector<Segment> walls;
  AddOutline(walls, {0, 0}, {10, 10});
  AddOutline(walls, {6, 4.5}, {7, 5.5});  // a pillar: one side of it faces the cell
  Box box;
  box.Add(Segment{{1, 4.6}, {2, 5.4}});
  EXPECT_EQ(WallsSeenFrom(SegmentTree(walls), box).size(), 5u);
}

TEST(VisibleWallsTest, OutlinesThatCrossThemselvesHaveNoBack) {
  // Two loops of one chain, each around the other way.
  const std::vector<Vec2> corners{{0, 0}, {10, 10}, {10, 0}, {0, 10}};
  std::vector<Segment> walls;
  for (size_t i = 0; i < 4; ++i) walls.push_back({corners[i], corners[(i + 1) % 4]});
  const SegmentTree all(walls);
  const BeamFan fan(-3.1, 0.01, 620);
  for (const Vec2 low : {Vec2{-2.0, 4.5}, Vec2{11.0, 4.5}}) {
    Box box;
    box.Add(Segment{low, low + Vec2{1, 1}});
    const WallList seen(walls, WallsSeenFrom(all, box), low);
    const Pose pose{low.x + 0.3, low.y + 0.6, 0.4};
    EXPECT_EQ(Scan(fan, seen, pose), Scan(fan, all, pose)) << low.x;
  }
}

/// Outlines with steps of 5 cm, as map images give them, and open chains in all directions.
std::vector<Segment> Chains(int seed) {
  Dice dice(seed);
  std::vector<Segment> walls;
  const auto add = [&](Vec2& end, Vec2 way) {
    walls.push_back({end, end + way});
    end = walls.back().b;
  };
  for (int i = 0; i < 12; ++i) {
    Vec2 end{dice(0, 8), dice(0, 8)};
    for (int k = 0; k < 30; ++k)
      add(end, k % 2 == 0 ? Vec2{0.1, 0} : Vec2{0, k % 4 < 2 ? 0.05 : -0.05});
    end = {dice(0, 8), dice(0, 8)};
    double yaw = dice(-3, 3);
    for (int k = 0; k < 20; ++k) {
      yaw += dice(-0.9, 0.9);
      const double length = dice(0.02, 0.6);
      add(end, {length * std::cos(yaw), length * std::sin(yaw)});
    }
  }
  return walls;
}

TEST(VisibleWallsTest, ScansAreTheSameBetweenChains) {
  const BeamFan fan(-3.1, 0.01, 620);
  for (int seed = 0; seed < 4; ++seed) {
    Dice dice(200 + seed);
    const SegmentTree all(Chains(seed));
    for (int cell = 0; cell < Rounds(40); ++cell) {
      const Vec2 low{dice(0, 8), dice(0, 8)};
      Box box;
      box.Add(Segment{low, low + Vec2{0.5, 0.5}});
      const WallList seen(all.segments(), WallsSeenFrom(all, box), low);
      for (int i = 0; i < 12; ++i) {
        const double x = i < 4 ? 0.5 * (i % 2) : dice(0, 0.5),
                     y = i < 4 ? 0.5 * (i / 2) : dice(0, 0.5);
        const Pose pose{low.x + x, low.y + y, dice(-3, 3)};
        ASSERT_EQ(Scan(fan, seen, pose), Scan(fan, all, pose)) << seed << " " << cell << " " << i;
      }
    }
  }
}

TEST(VisibleWallsTest, WallsBehindAChainAreLeftOut) {
  std::vector<Segment> walls;  // a wall along x with steps, and pillars behind it
  Vec2 end{0, 5};
  for (int i = 0; i < 200; ++i) {
    const Vec2 begin = end;
    end = begin + (i % 2 == 0 ? Vec2{0.2, 0} : Vec2{0, i % 4 == 1 ? 0.05 : -0.05});
    walls.push_back({begin, end});
  }
  const size_t chain = walls.size();
  for (int i = 0; i < 40; ++i) AddOutline(walls, {7 + 0.15 * i, 6}, {7.1 + 0.15 * i, 6.1});
  Box box;
  box.Add(Segment{{9.75, 3}, {10.25, 3.5}});
  size_t behind = 0;
  for (const uint32_t index : WallsSeenFrom(SegmentTree(walls), box)) behind += index >= chain;
  EXPECT_EQ(behind, 0u);
}

TEST(VisibleWallsTest, AreFoundWhereManyScansAreMade) {
  const auto walls = std::make_shared<const SegmentTree>(HallAndRooms(1));
  const VisibleWalls visible(walls);
  const Vec2 place{10.5, 10.5};
  for (int i = 1; i < VisibleWalls::kScansBefore; ++i) {
    ASSERT_EQ(visible.SeenFrom(place), nullptr);
  }
  const WallList* seen = nullptr;
  int portions = 0;
  for (; portions < 1000 && seen == nullptr; ++portions) seen = visible.SeenFrom(place);
  ASSERT_NE(seen, nullptr);
  EXPECT_GT(portions, 5);  // no scan makes the whole search
  EXPECT_LT(seen->size(), walls->segment_count());
  EXPECT_EQ(visible.SeenFrom(place), seen);
  EXPECT_EQ(visible.SeenFrom({100, 100}), nullptr);
  EXPECT_EQ(visible.SeenFrom({std::nan(""), 0}), nullptr);
}

TEST(VisibleWallsTest, AreFoundByOneScanThatMayMakeTheWholeSearch) {
  const VisibleWalls visible(std::make_shared<const SegmentTree>(HallAndRooms(1)));
  const Vec2 place{10.5, 10.5};
  for (int i = 1; i < VisibleWalls::kScansBeforeInBatch; ++i) {
    ASSERT_EQ(visible.SeenFrom(place, VisibleWalls::kWholeSearch), nullptr);
  }
  EXPECT_NE(visible.SeenFrom(place, VisibleWalls::kWholeSearch), nullptr);
}

TEST(VisibleWallsTest, ManyThreadsMayAsk) {
  const VisibleWalls visible(std::make_shared<const SegmentTree>(HallAndRooms(2)));
  const BeamFan fan(-3.0, 0.1, 60);
  std::vector<std::thread> threads;
  for (int i = 0; i < 4; ++i) {
    threads.emplace_back([&, i] {
      Dice dice(i);
      for (int k = 0; k < 2000; ++k) {
        const Pose pose{dice(3, 6), dice(3, 6), 0.0};
        const WallList* seen = visible.SeenFrom({pose.x, pose.y});
        if (seen == nullptr || k % 20 != 0) continue;
        EXPECT_EQ(Scan(fan, *seen, pose), Scan(fan, visible.all(), pose));
      }
    });
  }
  for (std::thread& thread : threads) thread.join();
}

TEST(VisibleWallsTest, ScansAreTheSameWithWallsFoundAmongThoseOfALargerCell) {
  const BeamFan fan(-3.1, 0.01, 620);
  const SegmentTree all(Chains(7));
  const Occluders occluders(all);
  Dice dice(300);
  for (int cell = 0; cell < Rounds(40); ++cell) {
    const Vec2 low{dice(0, 7), dice(0, 7)};
    Box large, small;
    large.Add(Segment{low, low + Vec2{1, 1}});
    small.Add(Segment{low, low + Vec2{0.5, 0.5}});
    const std::vector<uint32_t> around = WallsSeenFrom(all, occluders, large);
    WallSearch search(all, occluders, small, &around);
    search.Continue(INT_MAX);
    EXPECT_LE(search.seen().size(), around.size());
    const WallList seen(all.segments(), search.seen(), low);
    for (int i = 0; i < 12; ++i) {
      const double x = i < 4 ? 0.5 * (i % 2) : dice(0, 0.5), y = i < 4 ? 0.25 * i : dice(0, 0.5);
      const Pose pose{low.x + x, low.y + std::min(y, 0.5), dice(-3, 3)};
      ASSERT_EQ(Scan(fan, seen, pose), Scan(fan, all, pose)) << cell << " " << i;
    }
  }
}

TEST(VisibleWallsTest, AreTakenByEqualLayers) {
  const auto walls = std::make_shared<const SegmentTree>(HallAndRooms(3));
  const VisibleWalls first(walls), second(walls), third(walls);
  std::vector<Vec2> points;
  Dice dice(1);
  for (int i = 0; i < 60; ++i) {
    points.push_back({dice(0, 25), dice(0, 20)});
    for (int scan = 0; scan < 1000; ++scan) first.SeenFrom(points.back());
  }
  const std::vector<uint32_t> known = first.GetKnown();
  ASSERT_TRUE(second.Take(known));
  EXPECT_EQ(second.GetKnown(), known);
  const BeamFan fan(-3.0, 0.1, 60);
  int lists = 0;
  for (const Vec2& point : points) {
    const Pose pose{point.x, point.y, dice(-3, 3)};
    const WallList* const seen = second.SeenFrom({pose.x, pose.y});
    if (seen == nullptr) continue;
    ++lists;
    ASSERT_EQ(Scan(fan, *seen, pose), Scan(fan, *walls, pose));
  }
  EXPECT_GT(lists, 40);

  std::vector<uint32_t> wrong = known;
  wrong.back() = static_cast<uint32_t>(walls->segment_count());
  for (const auto& each : {std::vector<uint32_t>(known.begin(), known.end() - 1), wrong,
                           std::vector<uint32_t>(), std::vector<uint32_t>{known[0], 5u}}) {
    EXPECT_FALSE(third.Take(each));
  }
  wrong = known;
  wrong.push_back(VisibleWalls::kUnknown);
  EXPECT_FALSE(third.Take(wrong));
  wrong = third.GetKnown();
  EXPECT_EQ(wrong, std::vector<uint32_t>(wrong.size(), VisibleWalls::kUnknown));
}

TEST(VisibleWallsTest, TheSizeOfPortionsDoesNotMatter) {
  const SegmentTree all(Chains(5));
  const Occluders occluders(all);
  Box box;
  box.Add(Segment{{3, 3}, {3.5, 3.5}});
  for (const int effort : {1, 7, 1000}) {
    WallSearch search(all, occluders, box);
    int portions = 1;
    while (!search.Continue(effort)) ++portions;
    EXPECT_GT(portions, 1);
    EXPECT_EQ(search.seen(), WallsSeenFrom(all, box));
  }
}

TEST(VisibleWallsTest, EqualLayersShareThem) {
  const auto first = VisibleWalls::Share(Hall(3));
  EXPECT_EQ(VisibleWalls::Share(Hall(3)), first);
  EXPECT_NE(VisibleWalls::Share(Hall(4)), first);
}

}  // namespace
}  // namespace flatland
