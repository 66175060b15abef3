#include "motion/body_drift.hpp"

#include <gtest/gtest.h>

#include <stdexcept>

#include "test_bodies.hpp"
#include "test_numbers.hpp"

namespace flatland {
namespace {

TEST(BodyDriftTest, TheArcOfAMotionIsItsVelocityTimesTheTime) {
  for (const double turn : {0.0, 1e-9, 1e-3, -0.7, 2.0, 3.1}) {
    for (const Vec2 way : {Vec2{1.0, 0.0}, Vec2{-0.5, 0.0}, Vec2{0.3, -0.4}, Vec2{}}) {
      Pose motion;
      constexpr int kSteps = 2000;
      for (int i = 0; i < kSteps; ++i) {
        // Half a step's turn, a straight step, and the other half.
        const Pose half{0.0, 0.0, turn / kSteps / 2.0};
        motion = Compose(motion, half);
        motion = Compose(motion, {way.x / kSteps, way.y / kSteps, 0.0});
        motion = Compose(motion, half);
      }
      EXPECT_NEAR(MotionAlong({way.x, way.y, turn}).x, motion.x, 1e-5);
      EXPECT_NEAR(MotionAlong({way.x, way.y, turn}).y, motion.y, 1e-5);
      EXPECT_NEAR(ArcOf(motion).x, way.x, 1e-5);
      EXPECT_NEAR(ArcOf(motion).y, way.y, 1e-5);
    }
  }
}

class BodyDriftWorldTest : public WorldTest {
 protected:
  World::Drift Add(uint64_t key, const DriftVariances& variances = {0.01, 0.02, 0.03, 0.04, {}}) {
    return world_.AddDrift(robot_, variances, period_, key);
  }
  double period_ = 0.0;
  World::Body robot_ = world_.AddBody(At({3, -2, 0.5}, b2_kinematicBody));
};

TEST_F(BodyDriftWorldTest, ThePoseIsTheIntegralOfTheMeasuredVelocity) {
  // Of one step of 5 ms, or of two: their mean does not know how noise has bent the path between.
  for (const double period : {0.0, 0.01}) {
    period_ = period;
    const World::Drift drift = Add(1, {0.01, 0.02, 0.03, 0.04, {0.1, 0.1, 0.1}, {0.1, 0.1, 0.1}});
    world_.SetVelocity(robot_, {0.5, 0.1, 0.3});
    Pose integral = world_.GetEstimate(drift);
    const int steps = period > 0.0 ? 2 : 1;
    for (int i = 0; i < 100; ++i) {
      StepTimes(world_, steps);
      const auto [vx, vy, omega] = world_.Get(drift).MeasuredVelocity();
      const double dt = steps * kStep;
      integral = Wrapped(Compose(integral, MotionAlong({vx * dt, vy * dt, omega * dt})));
    }
    ExpectPose(integral, world_.GetEstimate(drift), period > 0.0 ? 1e-2 : 1e-9);
  }
}

TEST_F(BodyDriftWorldTest, BiasesScaleTheMotionAndNoneIsWhite) {
  const World::Drift drift = Add(3, {0, 0, 0, 0, {}, {0.1, 0.1, 0.1}});
  world_.SetVelocity(robot_, {1.0, 0.0, 0.0});
  StepTimes(world_, 1);
  const Twist first = world_.Get(drift).MeasuredVelocity();
  StepTimes(world_, 200);
  EXPECT_GT(std::abs(first.omega), 1e-3);
  ExpectTwist(world_.Get(drift).MeasuredVelocity(), first, 1e-4);
}

TEST_F(BodyDriftWorldTest, ErrorsDependOnTheKey) {
  const World::Drift a = Add(1), b = Add(1), c = Add(2);
  world_.SetVelocity(robot_, {0.5, 0.1, 0.3});
  StepTimes(world_, 100);
  EXPECT_TRUE(world_.GetEstimate(a) == world_.GetEstimate(b));
  EXPECT_FALSE(world_.GetEstimate(a) == world_.GetEstimate(c));
}

TEST_F(BodyDriftWorldTest, ABodyAtRestDoesNotDrift) {
  const World::Drift drift = Add(1);
  world_.SetVelocity(robot_, {0.5, 0.1, 0.3});
  StepTimes(world_, 100);
  world_.SetVelocity(robot_, {});
  const Pose before = world_.GetEstimate(drift);
  StepTimes(world_, 100);
  EXPECT_TRUE(world_.GetEstimate(drift) == before);
}

TEST_F(BodyDriftWorldTest, ASavedStateGoesOnAlike) {
  const World::Drift drift = Add(1);
  world_.SetVelocity(robot_, {0.5, 0.1, 0.3});
  StepTimes(world_, 50);
  const std::string state = world_.SaveState();
  StepTimes(world_, 50);
  const Pose expected = world_.GetEstimate(drift);
  world_.RestoreState(state);
  StepTimes(world_, 50);
  EXPECT_TRUE(world_.GetEstimate(drift) == expected);
}

TEST_F(BodyDriftWorldTest, RefusesVariancesThatAreNone) {
  for (const double wrong : {-1.0, kNaN}) {
    EXPECT_THROW(Add(1, {wrong, 0, 0, 0, {}}), std::invalid_argument);
    EXPECT_THROW(Add(1, {0, 0, 0, 0, {0, wrong, 0}}), std::invalid_argument);
    EXPECT_THROW(Add(1, {0, 0, 0, 0, {}, {0, 0, wrong}}), std::invalid_argument);
  }
}

}  // namespace
}  // namespace flatland
