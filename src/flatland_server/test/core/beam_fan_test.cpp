#include "sight/beam_fan.hpp"

#include <gtest/gtest.h>

#include <ostream>
#include <random>
#include <set>
#include <stdexcept>

#include "test_numbers.hpp"
#include "test_rounds.hpp"

namespace flatland {
namespace {

void ExpectDirection(Vec2 direction, double angle) {
  EXPECT_NEAR(direction.x, std::cos(angle), 1e-12);
  EXPECT_NEAR(direction.y, std::sin(angle), 1e-12);
}

TEST(BeamFan, GoesByItsIncrementFromItsFirstAngle) {
  for (const double sign : {1.0, -1.0}) {  // counterclockwise, and clockwise
    const BeamFan fan(-0.5 * sign, 0.25 * sign, 5);

    ASSERT_EQ(fan.size(), 5);
    for (int beam = 0; beam < 5; ++beam) {
      ExpectDirection(fan.direction(beam), sign * (0.25 * beam - 0.5));
    }
  }
  const BeamFan single(2.0, 0.0, 1);  // one needs no increment
  ASSERT_EQ(single.size(), 1);
  ExpectDirection(single.direction(0), 2.0);
}

TEST(BeamFan, RefusesAnglesThatAreNotFiniteNoBeamsAndTwoInOneDirection) {
  for (double bad : {kNaN, kInfinity, -kInfinity}) {
    EXPECT_THROW(BeamFan(bad, 0.1, 3), std::invalid_argument);
    EXPECT_THROW(BeamFan(0.0, bad, 3), std::invalid_argument);
  }
  EXPECT_THROW(BeamFan(0.0, 0.1, 0), std::invalid_argument);
  EXPECT_THROW(BeamFan(0.0, 0.1, -1), std::invalid_argument);
  EXPECT_THROW(BeamFan(0.0, 0.0, 2), std::invalid_argument);
}

struct FanCase {
  const char* name;
  double angle_min;
  double span;  // from the first beam to the last [rad], negative for clockwise
  int count;
};

void PrintTo(const FanCase& fan, std::ostream* out) { *out << fan.name; }

class BeamsNear : public testing::TestWithParam<FanCase> {
 protected:
  BeamFan fan_{GetParam().angle_min, GetParam().span / (GetParam().count - 1), GetParam().count};

  std::multiset<int> Visit(double bearing, double half_width) const {
    const auto towards = [](double angle) { return Vec2{std::cos(angle), std::sin(angle)}; };
    std::multiset<int> visited;
    for (const auto& [begin, end] :
         fan_.BeamsBetween(towards(bearing - half_width), towards(bearing + half_width))) {
      for (int rank = begin; rank < end; ++rank) visited.insert(fan_.beams()[rank]);
    }
    return visited;
  }

  // Every beam with a direction within half_width of the bearing must be visited exactly once.
  void ExpectAllVisited(double bearing, double half_width) const {
    const std::multiset<int> visited = Visit(bearing, half_width);

    for (int beam = 0; beam < fan_.size(); ++beam) {
      EXPECT_LE(visited.count(beam), 1u);
      const double angle = GetParam().angle_min + beam * GetParam().span / (GetParam().count - 1);
      const double apart = std::abs(std::remainder(angle - bearing, 2.0 * M_PI));
      if (apart > half_width || visited.count(beam) == 1) continue;
      ADD_FAILURE() << "beam " << beam << " at " << angle << " is missed near " << bearing
                    << " with half width " << half_width;
    }
  }
};

TEST_P(BeamsNear, AreAllVisitedForRandomBearings) {
  std::mt19937 random(1);
  std::uniform_real_distribution<double> bearing(-M_PI, M_PI);
  std::uniform_real_distribution<double> half_width(0.0, M_PI / 2);

  for (int i = 0; i < Rounds(2000); ++i) ExpectAllVisited(bearing(random), half_width(random));
}

TEST_P(BeamsNear, AreAllVisitedForNarrowThings) {
  std::mt19937 random(2);
  std::uniform_real_distribution<double> bearing(-M_PI, M_PI);

  for (int i = 0; i < Rounds(2000); ++i) {
    ExpectAllVisited(bearing(random), 0.6 * std::abs(GetParam().span) / (GetParam().count - 1));
  }
}

TEST_P(BeamsNear, AreAllVisitedStraightBehind) {
  for (double bearing : {-M_PI, -M_PI + 1e-9, -3.14, 3.14, M_PI - 1e-9, M_PI}) {
    for (double half_width : {0.0, 1e-6, 0.01, 0.5, 1.5, M_PI / 2}) {
      ExpectAllVisited(bearing, half_width);
    }
  }
}

TEST_P(BeamsNear, AreFewForNarrowThings) {
  for (double bearing = -3.0; bearing < 3.0; bearing += 0.1) {
    const double increment = std::abs(GetParam().span) / (GetParam().count - 1);
    const double per_rotation = 2.0 * (0.01 / increment + 1.0) + 1.0;
    const double rotations = std::ceil(std::abs(GetParam().span) / (2.0 * M_PI)) + 1.0;
    EXPECT_LE(Visit(bearing, 0.01).size(), per_rotation * rotations) << "near " << bearing;
  }
}

INSTANTIATE_TEST_SUITE_P(
    Fans, BeamsNear,
    testing::Values(FanCase{"narrow", -0.4, 0.8, 81}, FanCase{"narrow_clockwise", 0.4, -0.8, 81},
                    FanCase{"behind", 2.9, 0.6, 61}, FanCase{"behind_clockwise", -2.9, -0.6, 61},
                    FanCase{"three_quarters", -2.356, 4.712, 1081},
                    FanCase{"full_rotation", -M_PI, 2.0 * M_PI, 361},
                    FanCase{"full_rotation_clockwise", M_PI, -2.0 * M_PI, 361},
                    FanCase{"two_rotations", -M_PI, 4.0 * M_PI, 500},
                    FanCase{"two_rotations_clockwise", M_PI, -4.0 * M_PI, 500},
                    FanCase{"many_rotations_from_afar", 50.0, 3.5 * M_PI, 400}),
    [](const testing::TestParamInfo<FanCase>& info) { return info.param.name; });

TEST(BeamFan, CoarseFanOfManyRotationsMissesNothing) {
  const BeamFan fan(0.0, 5.0, 40);

  std::set<int> visited;
  for (const auto& [begin, end] :
       fan.BeamsBetween({std::cos(0.8), std::sin(0.8)}, {std::cos(1.2), std::sin(1.2)})) {
    visited.insert(fan.beams().begin() + begin, fan.beams().begin() + end);
  }

  for (int beam = 0; beam < fan.size(); ++beam) {
    const double apart = std::abs(std::remainder(beam * 5.0 - 1.0, 2.0 * M_PI));
    if (apart > 0.2) continue;
    EXPECT_EQ(visited.count(beam), 1u) << "beam " << beam;
  }
}

TEST(BeamFan, KnowsTheDirectionOfEachRank) {
  const BeamFan fan(1.0, -0.3, 30);

  ASSERT_EQ(fan.padded_size() % BeamFan::kGroup, 0);
  ASSERT_GE(fan.padded_size(), fan.size() + 2 * BeamFan::kGroup);  // two are drawn at once
  for (int rank = 0; rank < fan.padded_size(); ++rank) {
    const Vec2 expected = rank < fan.size() ? fan.direction(fan.beams()[rank]) : Vec2{};
    EXPECT_EQ(fan.xs()[rank], expected.x);
    EXPECT_EQ(fan.ys()[rank], expected.y);
  }
}

}  // namespace
}  // namespace flatland
