#include "motion/steering.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "reference_motion.hpp"

namespace flatland {
namespace {

struct Maneuver {
  const char* name;
  DynamicsLimits limits;
  SteeringState from;
  double to;
  Course rate;  // exact, by hand; its integral is the angle
};

void PrintTo(const Maneuver& maneuver, std::ostream* out) { *out << maneuver.name; }

Maneuver Steers(const char* name, const DynamicsLimits& limits, const SteeringState& from,
                double to, const std::vector<Course::Point>& rate) {
  return {name, limits, from, to, rate};
}

constexpr DynamicsLimits kAllLimits{2.0, 4.0, 0.5};

class Steering : public testing::TestWithParam<Maneuver> {};

// At steps of 1, 5 and 7 ms, at steps that straddle several pieces, and all at once.
TEST_P(Steering, FollowsItsClosedFormAtStepsOfAnyLength) {
  const Maneuver& maneuver = GetParam();
  for (const double dt : {0.001, 0.005, 0.007, 0.2, 0.6, 9.0}) {
    SteeringState state = maneuver.from;
    for (int step = 1; (step - 2) * dt < maneuver.rate.end(); ++step) {
      state = Steer(state, maneuver.to, maneuver.limits, dt);

      const double time = step * dt;
      const double angle = maneuver.from.angle + maneuver.rate.Integral(time);
      ASSERT_NEAR(state.angle, angle, 1e-9) << dt << " s, step " << step;
      if (maneuver.rate.IsSteadyAt(time)) {
        ASSERT_NEAR(state.rate, maneuver.rate.At(time), 1e-9) << dt << " s, step " << step;
      }
    }
    EXPECT_EQ(state.angle, maneuver.to) << dt;
    EXPECT_EQ(state.rate, 0.0) << dt;
  }
}

// Mirrored values give the mirrored motion.
TEST_P(Steering, IsTheSameToTheOtherSide) {
  const Maneuver& maneuver = GetParam();
  for (double time = 0.0; time < maneuver.rate.end() + 0.1; time += 0.01) {
    const SteeringState state = Steer(maneuver.from, maneuver.to, maneuver.limits, time);
    const SteeringState other =
        Steer({-maneuver.from.angle, -maneuver.from.rate}, -maneuver.to, maneuver.limits, time);

    ASSERT_EQ(other.angle, -state.angle) << time;
    ASSERT_EQ(other.rate, -state.rate) << time;
  }
}

// Without a velocity limit the rate is a triangle. For a distance d, an acceleration a and a
// deceleration b, its peak p is given by p^2 = 2 d / (1/a + 1/b).
INSTANTIATE_TEST_SUITE_P(
    FromRest, Steering,
    testing::Values(
        // 0.0625 rad up, 0.90625 along, 0.03125 down.
        Steers("trapezoid", kAllLimits, {0.0, 0.0}, 1.0,
               {{0, 0}, {0.25, 0.5}, {2.0625, 0.5}, {2.1875, 0}}),
        Steers("triangle", kAllLimits, {0.0, 0.0}, 0.03,
               {{0, 0}, {std::sqrt(0.02), 2 * std::sqrt(0.02)}, {1.5 * std::sqrt(0.02), 0}}),
        Steers("triangle_that_just_has_a_tip", kAllLimits, {-0.5, 0.0}, -0.40625,
               {{0, 0}, {0.25, 0.5}, {0.375, 0}}),
        Steers("trapezoid_without_velocity_limit", {2.0, 4.0, 0.0}, {0.0, 0.0}, 1.5,
               {{0, 0}, {1.0, 2.0}, {1.5, 0}}),
        Steers("velocity_limit_alone", {0.0, 0.0, 0.5}, {0.2, 0.0}, -0.8,
               {{0, -0.5}, {2, -0.5}, {2, 0}}),
        Steers("acceleration_limit_alone", {2.0, 0.0, 0.0}, {0.0, 0.0}, 1.0,
               {{0, 0}, {1, 2}, {1, 0}}),
        Steers("deceleration_limit_alone", {0.0, 2.0, 0.0}, {0.0, 0.0}, 1.0, {{0, 2}, {1, 0}}),
        Steers("no_deceleration_limit", {2.0, 0.0, 0.5}, {0.0, 0.0}, 1.0625,
               {{0, 0}, {0.25, 0.5}, {2.25, 0.5}, {2.25, 0}}),
        Steers("no_acceleration_limit", {0.0, 2.0, 0.5}, {0.0, 0.0}, 1.0625,
               {{0, 0.5}, {2, 0.5}, {2.25, 0}}),
        Steers("nowhere", kAllLimits, {0.3, 0.0}, 0.3, {{0, 0}, {0.1, 0}})),
    [](const testing::TestParamInfo<Maneuver>& info) { return info.param.name; });

// The target changes while the wheel is moving.
INSTANTIATE_TEST_SUITE_P(
    InMotion, Steering,
    testing::Values(
        // Half a second along and 0.125 s down: 0.25 + 0.03125 rad.
        Steers("goes_on", kAllLimits, {0.1, 0.5}, 0.38125, {{0, 0.5}, {0.5, 0.5}, {0.625, 0}}),
        Steers("speeds_up_further", kAllLimits, {0.0, 0.2}, 0.08375,
               {{0, 0.2}, {0.15, 0.5}, {0.275, 0}}),
        Steers("slows_down_at_once", kAllLimits, {0.0, 0.4}, 0.02, {{0, 0.4}, {0.1, 0}}),
        // 0.03125 rad on until it rests, 1 rad back.
        Steers("turns_round", kAllLimits, {0.2, 0.5}, 0.23125 - 1.0,
               {{0, 0.5}, {0.125, 0}, {0.375, -0.5}, {2.1875, -0.5}, {2.3125, 0}}),
        // To rest 0.03125 rad further on, 0.03 rad past the target, and back in a triangle.
        Steers("is_too_fast_to_stop", kAllLimits, {0.0, 0.5}, 0.00125,
               {{0, 0.5},
                {0.125, 0},
                {0.125 + std::sqrt(0.02), -2 * std::sqrt(0.02)},
                {0.125 + 1.5 * std::sqrt(0.02), 0}}),
        Steers("is_commanded_to_stay", kAllLimits, {0.0, -0.4}, 0.0,
               {{0, -0.4},
                {0.1, 0},
                {0.1 + std::sqrt(0.04 / 3.0), 2.0 * std::sqrt(0.04 / 3.0)},
                {0.1 + 1.5 * std::sqrt(0.04 / 3.0), 0}}),
        Steers("stays_at_once_without_deceleration_limit", {2.0, 0.0, 0.5}, {0.1, -0.4}, 0.1,
               {{0, 0}, {0.1, 0}}),
        Steers("turns_round_at_once_without_deceleration_limit", {2.0, 0.0, 0.0}, {1.0, 0.7}, 0.0,
               {{0, 0}, {1, -2}, {1, 0}}),
        Steers("turns_round_without_acceleration_limit", {0.0, 2.0, 0.5}, {0.0, 0.5}, -1.0,
               {{0, 0.5}, {0.25, 0}, {0.25, -0.5}, {2.25, -0.5}, {2.5, 0}})),
    [](const testing::TestParamInfo<Maneuver>& info) { return info.param.name; });

TEST(Steer, IsAtOnceWithoutLimitsAndTakesNoTimeForNoTime) {
  for (const double time : {0.0, 0.005, 3.0}) {
    const SteeringState state = Steer({0.3, 0.2}, -0.7, {}, time);
    EXPECT_EQ(state.angle, -0.7);
    EXPECT_EQ(state.rate, 0.0);
  }
  const SteeringState state = Steer({0.3, 0.2}, -0.7, {2.0, 4.0, 0.5}, 0.0);
  EXPECT_EQ(state.angle, 0.3);
  EXPECT_EQ(state.rate, 0.2);
}

class AnySteering : public testing::Test {
 protected:
  double Between(double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random_);
  }

  std::mt19937 random_{11};
};

// Random targets, changed at random times.
TEST_F(AnySteering, NeverExceedsItsLimitsAndArrives) {
  const double dt = 0.005;
  for (int i = 0; i < 500; ++i) {
    const DynamicsLimits limits{Between(0.1, 5), Between(0.1, 5), Between(0.1, 2)};
    SteeringState state{Between(-1, 1), 0.0};
    double target = 0.0;
    for (int change = 0; change < 6; ++change) {
      target = Between(-1.5, 1.5);
      const int steps = static_cast<int>(Between(1, 300));
      for (int step = 0; step < steps; ++step) {
        const SteeringState next = Steer(state, target, limits, dt);
        const double faster = std::abs(next.rate) - std::abs(state.rate);
        ASSERT_LE(std::abs(next.rate), limits.velocity + 1e-12);
        ASSERT_LE(faster, limits.acceleration * dt + 1e-12);
        ASSERT_GE(faster, -limits.deceleration * dt - 1e-9);
        ASSERT_LE(std::abs(next.rate - state.rate),
                  std::max(limits.acceleration, limits.deceleration) * dt + 1e-9);
        // The angle is the rate's integral: between the least and the most that it was.
        const double furthest = std::max(std::abs(state.rate), std::abs(next.rate)) * dt;
        ASSERT_LE(std::abs(next.angle - state.angle),
                  furthest + limits.acceleration * dt * dt + 1e-9);
        state = next;
      }
    }
    // Upper bounds of the time, there and back again.
    const double stop = limits.velocity / limits.deceleration;
    const double longest = 2.0 * stop + 3.0 / limits.velocity + 0.5 * limits.velocity * stop +
                           limits.velocity / limits.acceleration + 10.0;
    for (int step = 0; step * dt < longest; ++step) state = Steer(state, target, limits, dt);
    EXPECT_EQ(state.angle, target);
    EXPECT_EQ(state.rate, 0.0);
  }
}

TEST_F(AnySteering, IsTheSameInTwoStepsAsInOne) {
  const auto any_limit = [&] { return std::max(0.0, Between(-1, 3)); };
  for (int i = 0; i < 20000; ++i) {
    const DynamicsLimits limits{any_limit(), any_limit(), any_limit()};
    const double most = limits.velocity > 0.0 ? limits.velocity : 2.0;
    const SteeringState from{Between(-1, 1), Between(-most, most)};
    const double target = Between(-1, 1);
    const double first = Between(0.0, 1.5), second = Between(0.0, 1.5);

    const SteeringState whole = Steer(from, target, limits, first + second);
    const SteeringState ended = Steer(Steer(from, target, limits, first), target, limits, second);

    ASSERT_NEAR(ended.angle, whole.angle, 1e-8) << i;
    ASSERT_NEAR(ended.rate, whole.rate, 1e-4) << i;
  }
}

// If it moves towards a target at which it can stop, it never passes it.
TEST_F(AnySteering, DoesNotPassATargetThatItCanStopAt) {
  for (int i = 0; i < 500; ++i) {
    const DynamicsLimits limits{Between(0.1, 5), Between(0.1, 5), Between(0.1, 2)};
    const double rate = Between(0, limits.velocity);
    const double way = rate * rate / (2.0 * limits.deceleration) + Between(0.001, 1.0);
    SteeringState state{0.0, rate};
    for (int step = 0; step < 400; ++step) {
      const SteeringState next = Steer(state, way, limits, 0.005);
      ASSERT_GE(next.angle, state.angle - 1e-12);
      ASSERT_LE(next.angle, way + 1e-12);
      state = next;
    }
  }
}

}  // namespace
}  // namespace flatland
