#include "motion/dynamics_limits.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <random>
#include <stdexcept>

#include "reference_motion.hpp"
#include "test_numbers.hpp"

namespace flatland {
namespace {

void ExpectNear(Vec2 value, Vec2 expected, double tolerance) {
  EXPECT_NEAR(value.x, expected.x, tolerance);
  EXPECT_NEAR(value.y, expected.y, tolerance);
}

TEST(DynamicsLimits, AreFiniteAndNotNegative) {
  EXPECT_NO_THROW((DynamicsLimits{0.0, 0.5, 2.0}.Check()));
  for (double bad : {-0.1, kNaN, kInfinity}) {
    EXPECT_THROW((DynamicsLimits{bad, 0.0, 0.0}.Check()), std::invalid_argument) << bad;
    EXPECT_THROW((DynamicsLimits{0.0, bad, 0.0}.Check()), std::invalid_argument) << bad;
    EXPECT_THROW((DynamicsLimits{0.0, 0.0, bad}.Check()), std::invalid_argument) << bad;
  }
}

TEST(Approach, ReachesTheSmallestTarget) {
  const double tiny = std::numeric_limits<double>::denorm_min();
  for (const DynamicsLimits& limits : {DynamicsLimits{}, DynamicsLimits{2.0, 5.0, 1.0}}) {
    const VelocityChange change = limits.Approach({0.0, 0.0}, {tiny, 0.0}, 0.1);
    ExpectNear(change.reached, {0.0, 0.0}, 1e-300);
    ExpectNear(change.mean, {0.0, 0.0}, 1e-300);
  }
}

TEST(Approach, StaysAtTheTargetAndGoesNoFasterThanTheVelocityLimit) {
  const DynamicsLimits limits{2.0, 5.0, 0.5};

  EXPECT_EQ(limits.Approach(0.4, 0.4, 0.1), 0.4);
  EXPECT_EQ(limits.Approach(0.0, 0.0, 0.1), 0.0);
  EXPECT_EQ(limits.Approach({0.4, 0.0}, {0.4, 0.0}, 0.1).mean.x, 0.4);
  EXPECT_DOUBLE_EQ(limits.Approach(0.45, 3.0, 0.1), 0.5);
  EXPECT_DOUBLE_EQ(limits.Approach(-0.45, -3.0, 0.1), -0.5);
  EXPECT_DOUBLE_EQ(limits.Approach(0.5, 3.0, 0.1), 0.5);
}

TEST(Approach, ZeroIsNoLimit) {
  EXPECT_EQ(DynamicsLimits{}.Approach(-3.0, 100.0, 0.1), 100.0);
  EXPECT_EQ((DynamicsLimits{0.0, 1.0, 0.0}.Approach(0.0, 100.0, 0.1)), 100.0);
  EXPECT_EQ((DynamicsLimits{1.0, 0.0, 0.0}.Approach(100.0, 0.0, 0.1)), 0.0);
  // Stops at no cost of time, then has the whole step to speed up.
  EXPECT_NEAR((DynamicsLimits{1.0, 0.0, 0.0}.Approach(100.0, -100.0, 0.1)), -0.1, 1e-12);
}

// Changes at once take no time, and so count for nothing in the mean.
TEST(Approach, MeansTheWholeStepWhereThereIsNoLimit) {
  const auto mean = [](const DynamicsLimits& limits, double current, double target) {
    return limits.Approach({current, 0.0}, {target, 0.0}, 0.1).mean.x;
  };

  EXPECT_DOUBLE_EQ(mean({}, -3.0, 100.0), 100.0);
  EXPECT_DOUBLE_EQ(mean({0.0, 1.0, 0.0}, 0.0, 100.0), 100.0);
  EXPECT_NEAR(mean({1.0, 0.0, 0.0}, 100.0, -100.0), -0.05, 1e-12);
  // Stops in the first half of the step, is at -2 throughout the other.
  EXPECT_NEAR(mean({0.0, 4.0, 0.0}, 0.2, -2.0), 0.25 * 0.2 - 0.5 * 2.0, 1e-12);
}

struct Ride {
  const char* name;
  DynamicsLimits limits;
  double from;
  double to;
  Course course;  // the exact velocity, by hand
};

void PrintTo(const Ride& ride, std::ostream* out) { *out << ride.name; }

Ride Rides(const char* name, const DynamicsLimits& limits, double from, double to,
           const std::vector<Course::Point>& course) {
  return {name, limits, from, to, course};
}

class Trapezoid : public testing::TestWithParam<Ride> {};

// Steps of every length: of hundreds per piece, of several pieces each, and one over all of it.
TEST_P(Trapezoid, IsReachedAndIntegratedExactly) {
  const Ride& ride = GetParam();
  for (const double dt : {0.007, 0.13, 0.7, 1.9, 10.0}) {
    double velocity = ride.from;
    for (int step = 0; step * dt < ride.course.end() + 1.0; ++step) {
      const double start = step * dt, end = (step + 1) * dt;

      const VelocityChange change = ride.limits.Approach({velocity, 0.0}, {ride.to, 0.0}, dt);

      ASSERT_NEAR(change.reached.x, ride.course.At(end), 1e-12) << dt << " s, step " << step;
      ASSERT_NEAR(change.mean.x, ride.course.Mean(start, end), 1e-11) << dt << " s, step " << step;
      ASSERT_EQ(change.reached.y, 0.0);
      ASSERT_EQ(change.mean.y, 0.0);
      velocity = change.reached.x;
    }
    EXPECT_EQ(velocity, ride.course.At(100.0));  // there, not nearly there
  }
}

INSTANTIATE_TEST_SUITE_P(
    Rides, Trapezoid,
    testing::Values(
        Rides("from_rest", {0.5, 0.8, 0.0}, 0.0, 1.0, {{0, 0}, {2, 1}}),
        Rides("up_to_the_velocity_limit", {0.5, 0.8, 1.25}, 0.0, 7.0, {{0, 0}, {2.5, 1.25}}),
        Rides("to_rest", {0.5, 0.8, 0.0}, 1.0, 0.0, {{0, 1}, {1.25, 0}}),
        Rides("to_half_the_speed", {0.5, 0.8, 0.0}, -1.0, -0.5, {{0, -1}, {0.625, -0.5}}),
        Rides("reversal", {0.5, 0.8, 0.0}, 1.0, -0.6, {{0, 1}, {1.25, 0}, {2.45, -0.6}}),
        Rides("reversal_forwards", {0.5, 0.8, 0.0}, -1.0, 0.6, {{0, -1}, {1.25, 0}, {2.45, 0.6}}),
        Rides("down_to_the_velocity_limit", {0.5, 0.8, 1.0}, 3.0, 7.0, {{0, 3}, {2.5, 1}}),
        Rides("reversal_without_acceleration_limit", {0.0, 0.8, 0.0}, 1.0, -0.6,
              {{0, 1}, {1.25, 0}, {1.25, -0.6}}),
        Rides("reversal_without_deceleration_limit", {0.5, 0.0, 0.0}, 1.0, -0.6,
              {{0, 0}, {1.2, -0.6}})),
    [](const testing::TestParamInfo<Ride>& info) { return info.param.name; });

TEST(PlanarApproach, LimitsTheLengthOfTheVelocity) {
  const DynamicsLimits limits{0.0, 0.0, 1.0};

  ExpectNear(limits.Approach({0, 0}, {3, 4}, 0.1).reached, {0.6, 0.8}, 1e-12);
  ExpectNear(limits.Approach({0, 0}, {0.3, -0.4}, 0.1).reached, {0.3, -0.4}, 0.0);
}

TEST(PlanarApproach, IsOnALineWhatItIsAlongAnAxis) {
  const DynamicsLimits limits{2.0, 5.0, 0.5};

  const VelocityChange change = limits.Approach({0.12, 0.16}, {-6, -8}, 0.1);

  // 0.04 s to stop from 0.2 m/s; the other 0.06 s speed up the other way.
  ExpectNear(change.reached, {-0.6 * 0.12, -0.8 * 0.12}, 1e-12);
  const double mean = (0.04 * 0.1 - 0.06 * 0.06) / 0.1;
  ExpectNear(change.mean, {0.6 * mean, 0.8 * mean}, 1e-12);
}

// From along x to along y the straight way is sqrt(2) long. It comes nearest to zero half way, at
// (0.5, 0.5); up to there the speed falls.
TEST(PlanarApproach, TurnsACornerByTheDecelerationAndThenTheAcceleration) {
  const DynamicsLimits limits{0.5, 2.0, 0.0};
  const Course way({{0, 0}, {M_SQRT1_2 / 2.0, M_SQRT1_2}, {M_SQRT1_2 * 2.5, M_SQRT2}});
  const Vec2 along{-M_SQRT1_2, M_SQRT1_2};

  for (const double dt : {0.01, 0.3, 1.1}) {
    Vec2 velocity{1, 0};
    Vec2 moved{0, 0};
    for (int step = 1; step * dt < 4.0; ++step) {
      const VelocityChange change = limits.Approach(velocity, {0, 1}, dt);

      velocity = change.reached;
      moved = moved + dt * change.mean;

      const double time = step * dt;
      ExpectNear(velocity, Vec2{1, 0} + way.At(time) * along, 1e-12);
      ExpectNear(moved, Vec2{time, 0} + way.Integral(time) * along, 1e-11);
    }
    ExpectNear(velocity, {0, 1}, 0.0);
  }
}

class AnyApproach : public testing::Test {
 protected:
  double Between(double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random_);
  }
  Vec2 AnyVelocity() { return {Between(-2, 2), Between(-2, 2)}; }
  // Every fourth limit is none.
  double AnyLimit() { return std::max(0.0, Between(-1, 3)); }
  DynamicsLimits AnyLimits() { return {AnyLimit(), AnyLimit(), AnyLimit()}; }

  std::mt19937 random_{7};
};

TEST_F(AnyApproach, TurnsWithItsVelocities) {
  for (int i = 0; i < 2000; ++i) {
    const DynamicsLimits limits = AnyLimits();
    const Vec2 current = AnyVelocity(), target = AnyVelocity();
    const double dt = Between(0.001, 1.5);
    const Rotation turn(Between(-M_PI, M_PI));

    const VelocityChange change = limits.Approach(current, target, dt);
    const VelocityChange turned = limits.Approach(turn.Apply(current), turn.Apply(target), dt);

    ExpectNear(turned.reached, turn.Apply(change.reached), 1e-12);
    ExpectNear(turned.mean, turn.Apply(change.mean), 1e-12);
  }
}

TEST_F(AnyApproach, IsTheSameInTwoStepsAsInOne) {
  for (int i = 0; i < 2000; ++i) {
    const DynamicsLimits limits = AnyLimits();
    const Vec2 current = AnyVelocity(), target = AnyVelocity();
    const double first = Between(0.001, 1.0), second = Between(0.001, 1.0);

    const VelocityChange whole = limits.Approach(current, target, first + second);
    const VelocityChange begun = limits.Approach(current, target, first);
    const VelocityChange ended = limits.Approach(begun.reached, target, second);

    ExpectNear(ended.reached, whole.reached, 1e-9);
    ExpectNear(first * begun.mean + second * ended.mean, (first + second) * whole.mean, 1e-9);
  }
}

TEST_F(AnyApproach, ChangesNoFasterThanItMay) {
  const double dt = 0.02;
  for (int i = 0; i < 2000; ++i) {
    const DynamicsLimits limits{Between(0.1, 3), Between(0.1, 3), Between(0.1, 3)};
    const Vec2 target = AnyVelocity();
    Vec2 velocity = AnyVelocity();
    for (int step = 0; step < 50; ++step) {
      const Vec2 reached = limits.Approach(velocity, target, dt).reached;

      const bool slows_down = Dot(velocity, reached - velocity) < 0.0;
      const double most =
          slows_down ? std::max(limits.acceleration, limits.deceleration) : limits.acceleration;
      ASSERT_LE(LengthOf(reached - velocity), most * dt + 1e-12);
      ASSERT_LE(LengthOf(reached), std::max(LengthOf(velocity), limits.velocity) + 1e-12);
      ASSERT_LE(LengthOf(velocity) - LengthOf(reached), limits.deceleration * dt + 1e-12);
      velocity = reached;
    }
  }
}

}  // namespace
}  // namespace flatland
