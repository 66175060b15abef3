/// Actuators of drives, against their closed forms.

#include "motion/actuator.hpp"

#include <gtest/gtest.h>

#include <memory>
#include <stdexcept>

#include "batch/world_batch.hpp"
#include "test_bodies.hpp"
#include "test_numbers.hpp"

namespace flatland {
namespace {

ActuatorSettings Linear(const AxisSettings& axis) {
  ActuatorSettings settings;
  settings.linear = axis;
  return settings;
}

class ActuatedRobot : public WorldTest {
 protected:
  World::Drive Add(const ActuatorSettings& actuator, const DynamicsLimits& linear = {}) {
    body_ = AddBox(world_, {}, 0.4);
    return world_.AddDrive(body_, linear, {}, actuator);
  }
  double x() const { return world_.GetPose(body_).x; }
  double speed() const { return world_.GetLocalVelocity(body_).vx; }

  World::Body body_;
};

TEST(ActuatorSettings, AreRefusedIfTheyAreNegativeNotFiniteOrTooLong) {
  for (const AxisSettings& axis :
       {AxisSettings{-0.1}, AxisSettings{kNaN}, AxisSettings{10.1}, AxisSettings{0.0, -1.0},
        AxisSettings{0.0, 0.0, -1.0}, AxisSettings{0.0, 0.0, 0.0, 2e9}}) {
    EXPECT_THROW(Actuator(Linear(axis), false), std::invalid_argument);
  }
  ActuatorSettings settings;
  settings.command_timeout = -1.0;
  EXPECT_THROW(Actuator(settings, false), std::invalid_argument);
}

// 0.1 s are 20 steps; 0.0974 s as well: a command acts from the beginning of a step on.
TEST_F(ActuatedRobot, IsDelayedExactlyToTheStep) {
  for (const double delay : {0.1, 0.0974}) {
    SCOPED_TRACE(delay);
    const World::Drive drive = Add(Linear({delay}));
    StepTimes(world_, 7);
    world_.Get(drive).Command({1.0, 0.0, 0.0});
    StepTimes(world_, 3);
    world_.Get(drive).Command({2.0, 0.0, 0.0});
    StepTimes(world_, 17);
    EXPECT_EQ(x(), 0.0);
    StepTimes(world_, 3);
    EXPECT_NEAR(x(), 3 * kStep * 1.0, 1e-6);
    StepTimes(world_, 1);
    EXPECT_NEAR(x(), 3 * kStep * 1.0 + kStep * 2.0, 1e-6);
    EXPECT_EQ(world_.Get(drive).target().vx, 2.0);
    world_.RemoveBody(body_);
  }
}

TEST_F(ActuatedRobot, LagsInFirstOrderWhateverTheStep) {
  const double lag = 0.3;
  for (const double step : {0.001, 0.005, 0.1, 0.5}) {
    SCOPED_TRACE(step);
    const World::Drive drive = Add(Linear({0.0, lag}));
    world_.Get(drive).Command({1.0, 0.0, 0.0});
    for (int i = 1; i * step < 2.0 + 1e-9; ++i) {
      world_.Step(step);
      const double t = i * step, rest = std::exp(-t / lag);
      ASSERT_NEAR(speed(), 1.0 - rest, 1e-6) << t;
      ASSERT_NEAR(x(), t - lag * (1.0 - rest), 1e-6) << t;
    }
    world_.RemoveBody(body_);
  }
}

// The input is a t until it is 1 m/s, after 2 s, and constant from then on.
TEST_F(ActuatedRobot, LagsBehindItsRamp) {
  const double lag = 0.3, a = 0.5;
  const World::Drive drive = Add(Linear({0.0, lag}), {a, a, 1.0});
  world_.Get(drive).Command({5.0, 0.0, 0.0});
  for (int i = 1; i <= 800; ++i) {
    world_.Step(kStep);
    const double t = i * kStep, ramped = std::min(t, 2.0);
    double expected = a * (ramped - lag + lag * std::exp(-ramped / lag));
    if (t > 2.0) expected = 1.0 + (expected - 1.0) * std::exp(-(t - 2.0) / lag);
    ASSERT_NEAR(speed(), expected, 1e-6) << t;
  }
  EXPECT_NEAR(x(), 4.0 - 1.0 - lag * speed(), 1e-5);  // of the ramp 3 m; x = u - lag y
}

TEST_F(ActuatedRobot, IsAtRestAfterALagAndFallsAsleep) {
  const World::Drive drive = Add(Linear({0.0, 0.1}));
  world_.Get(drive).Command({1.0, 0.0, 0.0});
  StepTimes(world_, 200);
  world_.Get(drive).Command({});
  StepTimes(world_, 1000);
  EXPECT_EQ(world_.Get(drive).velocity().vx, 0.0);
  EXPECT_FALSE(world_.IsAwake(body_));
}

TEST_F(ActuatedRobot, IgnoresCommandsInItsDeadBand) {
  ActuatorSettings settings = Linear({0.0, 0.0, 0.1});
  settings.angular.dead_band = 0.2;
  const World::Drive drive = Add(settings);
  world_.Get(drive).Command({0.07, 0.07, -0.19});  // 0.099 m/s
  StepTimes(world_, 10);
  EXPECT_EQ(x(), 0.0);
  EXPECT_EQ(world_.GetPose(body_).yaw, 0.0);
  world_.Get(drive).Command({-0.1, 0.0, -0.2});
  StepTimes(world_, 10);
  EXPECT_NEAR(speed(), -0.1, 1e-6);
  EXPECT_NEAR(world_.GetPose(body_).yaw, -0.2 * 10 * kStep, 1e-6);
}

TEST_F(ActuatedRobot, BrakesWithinItsLimitsAfterATimeWithoutCommands) {
  ActuatorSettings settings;
  settings.command_timeout = 0.5;
  const World::Drive drive = Add(settings, {0.0, 2.0, 0.0});
  for (int i = 0; i < 4; ++i) {  // an equal command counts
    world_.Get(drive).Command({1.0, 0.0, 0.0});
    StepTimes(world_, 99);
    EXPECT_NEAR(speed(), 1.0, 1e-6);
  }
  StepTimes(world_, 1);
  EXPECT_NEAR(speed(), 1.0, 1e-6);
  StepTimes(world_, 1);
  EXPECT_NEAR(speed(), 1.0 - 2.0 * kStep, 1e-6);
  StepTimes(world_, 100);
  EXPECT_EQ(speed(), 0.0);
  world_.Get(drive).Command({1.0, 0.0, 0.0});
  StepTimes(world_, 1);
  EXPECT_NEAR(speed(), 1.0, 1e-6);
}

// The variance of the way grows by the noise in each second, whatever the step and the lag.
TEST_F(ActuatedRobot, HasNoiseThatIsTheSameWithStepsOfAnyLength) {
  constexpr int kRobots = 400;
  for (const auto& [step, lag] : {std::pair{0.02, 0.0}, {0.1, 0.0}, {0.02, 0.1}}) {
    SCOPED_TRACE(testing::Message() << step << " " << lag);
    World world{1, 1};
    std::vector<World::Body> robots;
    for (int i = 0; i < kRobots; ++i) {
      robots.push_back(AddBox(world, {}, 0.4, Ghost()));
      ActuatorSettings settings = Linear({0.0, lag, 0.0, 1e-3});
      settings.key = i;
      world.Get(world.AddDrive(robots.back(), {}, {}, settings)).Command({1.0, 0.0, 0.0});
    }
    for (int i = 0; i * step < 4.0 - 1e-9; ++i) world.Step(step);
    double sum = 0.0;
    for (const World::Body& robot : robots) {
      sum += std::pow(world.GetPose(robot).x - 4.0 + lag, 2);
    }
    // The lag holds back what came in last: -1.5 lag, for a step of infinite frequency.
    EXPECT_NEAR(sum / kRobots, 1e-3 * (4.0 - 1.5 * lag), 4 * 1e-3 * 4.0 * std::sqrt(2.0 / kRobots));
  }
}

class ActuatedTricycle : public WorldTest {
 protected:
  ActuatedTricycle() {
    const World::Body wheel = AddBox(world_, {}, 0.1);
    joint_ = world_.AddRevolute(base_, wheel, {});
  }
  World::Tricycle Add(const ActuatorSettings& actuator, const DynamicsLimits& steering = {}) {
    TricycleSettings settings;
    settings.rear_axle = {-1.0, 0.0};
    settings.steering = steering;
    settings.actuator = actuator;
    return world_.AddTricycle(base_, joint_, settings);
  }

  World::Body base_ = AddBox(world_, {}, 1.0);
  World::Joint joint_;
};

TEST_F(ActuatedTricycle, SteersWithALagAndADelay) {
  ActuatorSettings settings;
  settings.angular = {0.05, 0.2};
  TricycleDrive& drive = world_.Get(Add(settings));
  drive.Command(1.0, 0.5);
  StepTimes(world_, 10);
  EXPECT_EQ(drive.steer_angle(), 0.0);
  EXPECT_NEAR(world_.GetPose(base_).x, 10 * kStep, 1e-6);  // the speed has none
  StepTimes(world_, 40);
  EXPECT_NEAR(drive.steer_angle(), 0.5 * (1.0 - std::exp(-0.2 / 0.2)), 1e-9);
  EXPECT_NEAR(world_.GetJointAngle(joint_), drive.steer_angle(), 1e-5);
}

TEST_F(ActuatedTricycle, SteersBehindItsRateLimit) {
  ActuatorSettings settings;
  settings.angular = {0.0, 0.2};
  TricycleDrive& drive = world_.Get(Add(settings, {0.0, 0.0, 0.5}));
  drive.Command(0.0, 2.0);
  StepTimes(world_, 100);
  EXPECT_NEAR(drive.steer_angle(), 0.5 * (0.5 - 0.2 + 0.2 * std::exp(-0.5 / 0.2)), 1e-9);
}

TEST_F(ActuatedTricycle, HoldsItsAngleInTheDeadBandAndAfterATimeout) {
  ActuatorSettings settings;
  settings.angular.dead_band = 0.1;
  settings.command_timeout = 0.1;
  TricycleDrive& drive = world_.Get(Add(settings));
  drive.Command(1.0, 0.5);
  StepTimes(world_, 1);
  drive.Command(1.0, 0.45);
  StepTimes(world_, 1);
  EXPECT_EQ(drive.steer_angle(), 0.5);
  drive.Command(1.0, 0.39);
  StepTimes(world_, 50);
  EXPECT_EQ(drive.steer_angle(), 0.39);
  EXPECT_EQ(drive.speed(), 0.0);
}

/// A robot of all that an actuator keeps, with commands on their way.
class ActuatedWorld {
 public:
  ActuatedWorld() {
    body_ = AddBox(*world_, {}, 0.4);
    ActuatorSettings settings;
    settings.linear = {0.05, 0.1, 0.01, 1e-3};
    settings.angular = {0.02, 0.3, 0.01, 1e-3};
    settings.command_timeout = 0.2;
    settings.key = 7;
    drive_ = world_->AddDrive(body_, {1.0, 1.0, 0.0}, {}, settings);
    lidar_ = world_->lidars().Add(body_, LidarOf(0.0, 0.1, 1));
  }
  void Drive(World& world, int steps) {
    for (int i = 0; i < steps; ++i) {
      world.Get(drive_).Command({1.0 + 0.1 * (i % 7), 0.2, 0.3 * (i % 3)});
      world.Step(kStep);
    }
  }

  std::unique_ptr<World> world_ = std::make_unique<World>(10, 10);
  World::Body body_;
  World::Drive drive_;
  World::LidarHandle lidar_;
};

TEST(ActuatorState, IsSavedAndCopiedToTheLastBit) {
  ActuatedWorld robot;
  robot.Drive(*robot.world_, 20);
  const std::string saved = robot.world_->SaveState();
  const std::unique_ptr<World> copy = robot.world_->Copy();

  robot.Drive(*robot.world_, 50);
  const std::string after = robot.world_->SaveState();
  robot.Drive(*copy, 50);
  EXPECT_EQ(copy->SaveState(), after);
  robot.world_->RestoreState(saved);
  EXPECT_EQ(robot.world_->SaveState(), saved);
  robot.Drive(*robot.world_, 50);
  EXPECT_EQ(robot.world_->SaveState(), after);
}

TEST(ActuatorState, IsNotThatOfADriveWithoutOne) {
  ActuatedWorld robot;
  World other{10, 10};
  other.AddDrive(AddBox(other, {}, 0.4), {}, {});
  EXPECT_THROW(other.RestoreState(robot.world_->SaveState()), std::invalid_argument);
  EXPECT_THROW(robot.world_->RestoreState(other.SaveState()), std::invalid_argument);
}

TEST(ActuatorState, IsThatOfEachEnvironmentOfABatch) {
  constexpr int kCount = 5;
  ActuatedWorld robot;
  robot.Drive(*robot.world_, 20);
  BatchRobot in_batch;
  in_batch.bodies = {robot.body_};
  in_batch.drive = robot.drive_;
  in_batch.columns = {0, 1, 2};
  in_batch.action_size = 3;
  in_batch.lidar = robot.lidar_;
  WorldBatch batch(*robot.world_, {in_batch}, kCount, 2);
  std::vector<std::unique_ptr<World>> worlds;
  uint64_t keys[kCount];
  for (int i = 0; i < kCount; ++i) {
    worlds.push_back(robot.world_->Copy());
    keys[i] = 100 + i / 2;
    worlds[i]->Get(robot.drive_).Seed(keys[i]);
  }
  batch.Seed(nullptr, robot.drive_, keys);
  for (int step = 0; step < 60; ++step) {
    double actions[3 * kCount];
    for (int i = 0; i < kCount; ++i) {
      double* const action = actions + 3 * i;
      action[0] = 0.5 + 0.1 * i;
      action[1] = 0.1 * (step % 3);
      action[2] = step % 5 - 2.0;
      worlds[i]->Get(robot.drive_).Command({action[0], action[1], action[2]});
      worlds[i]->Step(kStep);
    }
    batch.Advance(actions, 1, kStep);
  }
  for (int i = 0; i < kCount; ++i) EXPECT_EQ(batch.SaveState(i), worlds[i]->SaveState()) << i;
  EXPECT_NE(batch.SaveState(0), batch.SaveState(2));
}

TEST(ActuatorState, IsForgottenByAHalt) {
  ActuatedWorld robot;
  robot.Drive(*robot.world_, 30);
  robot.world_->Halt(robot.body_);
  const Pose before = robot.world_->GetPose(robot.body_);
  StepTimes(*robot.world_, 30);
  EXPECT_EQ(robot.world_->GetPose(robot.body_), before);
}

}  // namespace
}  // namespace flatland
