/// OccluderField: the same as one occluder and one line at a time.

#include "../../src/core/four_occluders.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>
#include <vector>

#include "test_rounds.hpp"

namespace flatland {
namespace {

/// True if the line from a to b crosses the occluder, not just past its ends.
bool Crosses(const Segment& occluder, Vec2 a, Vec2 b) {
  const Vec2 along = occluder.b - occluder.a, way = b - a;
  const double before = Cross(along, a - occluder.a), behind = Cross(along, b - occluder.a);
  const double right = Cross(way, occluder.a - a), left = Cross(way, occluder.b - a);
  return before * behind < 0.0 && right * left < 0.0;
}

bool CrossesAll(const Segment& occluder, const SightLines& lines) {
  return std::all_of(lines.corners.begin(), lines.corners.end(), [&](Vec2 corner) {
    const bool starts_at_one_side =
        Cross(occluder.b - occluder.a, corner - occluder.a) *
            Cross(occluder.b - occluder.a, lines.corners[0] - occluder.a) >
        0.0;
    return starts_at_one_side && Crosses(occluder, corner, lines.to.a) &&
           Crosses(occluder, corner, lines.to.b);
  });
}

class FourOccludersTest : public testing::Test {
 protected:
  double Roll(double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(engine_);
  }

  const Box from_{{0, 0}, {1, 1}};
  std::mt19937 engine_{7};
};

TEST_F(FourOccludersTest, FindsWhatFindsOneAtATime) {
  int blocked = 0, middles = 0;
  for (int round = 0; round < Rounds(400); ++round) {
    const Vec2 end{Roll(6, 7), Roll(-2, 3)};
    const SightLines lines(from_, {end, end + Vec2{Roll(-0.5, 0.5), Roll(0.1, 1)}});
    std::vector<Segment> walls;
    OccluderField field;
    for (int i = 0; i < 1 + round % 40; ++i) {
      const Vec2 low{Roll(2, 5), Roll(-4, 2)};
      walls.push_back({low, low + Vec2{Roll(-1, 1), Roll(0, 4)}});
      field.Add({walls.back(), nullptr});
    }
    const bool is_blocked = std::any_of(
        walls.begin(), walls.end(), [&](const Segment& wall) { return CrossesAll(wall, lines); });
    const bool is_middle_crossed = std::any_of(walls.begin(), walls.end(), [&](const auto& wall) {
      return Crosses(wall, Middle(lines.from), Middle(lines.to));
    });
    for (int again = 0; again < 2; ++again) ASSERT_EQ(field.Block(lines), is_blocked) << round;
    std::vector<OccluderField::Some> some;
    field.Collect(Shaft(lines), lines, &some);
    const auto crossed = field.Cross(lines, some, 0, some.size());
    ASSERT_EQ(crossed == OccluderField::Crossed::kAll, is_blocked) << round;
    ASSERT_EQ(crossed != OccluderField::Crossed::kNone, is_middle_crossed) << round;
    blocked += is_blocked;
    middles += is_middle_crossed && !is_blocked;
    // Half of the lines need no others.
    const size_t end_of_all = some.size();
    const SightLines half = lines.Halves()[round % 2];
    field.Narrow(Shaft(half), 0, &some);
    EXPECT_LE(some.size() - end_of_all, end_of_all);
    ASSERT_EQ(field.Cross(half, some, end_of_all, some.size()),
              field.Cross(half, some, 0, end_of_all));
  }
  EXPECT_GT(blocked, Rounds(400) / 10);
  EXPECT_GT(middles, Rounds(400) / 25);
}

TEST_F(FourOccludersTest, AChordBlocksOnlyLinesThatEndOutsideOfItsChainsBox) {
  const SightLines lines(from_, {{6, 0}, {6, 1}});
  for (const double end : {5.0, 6.5}) {
    const Box chain{{2, -3}, {end, 4}};
    OccluderField field;
    field.Add({{{3, -3}, {3, 4}}, &chain});
    std::vector<OccluderField::Some> some;
    field.Collect(Shaft(lines), lines, &some);
    EXPECT_EQ(field.Block(lines), end < 6.0);
    EXPECT_EQ(some.size(), end < 6.0 ? 1u : 0u);
  }
}

}  // namespace
}  // namespace flatland
