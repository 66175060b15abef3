/// Drives of limited force, against Coulomb's law and Newton's.

#include "motion/grip.hpp"

#include <gtest/gtest.h>

#include <array>
#include <memory>
#include <stdexcept>

#include "batch/world_batch.hpp"
#include "test_bodies.hpp"

namespace flatland {
namespace {

constexpr double kGravity = 9.80665;

ActuatorSettings Limited(double max_force, double max_torque, double friction) {
  ActuatorSettings settings;
  settings.force = {max_force, max_torque, friction};
  return settings;
}

class GrippingRobot : public WorldTest {
 protected:
  /// A square of 0.5 m and 20 kg, if the force has limits.
  World::Body AddRobot(const ActuatorSettings& settings, const Pose& pose = {}) {
    const World::Body body = AddBox(world_, pose, 0.5, Dense(80.0));
    drive_ = world_.AddDrive(body, {}, {}, settings);
    return body;
  }
  double SpeedOf(World::Body body) const { return world_.GetLocalVelocity(body).vx; }

  World::Drive drive_;
};

TEST_F(GrippingRobot, SpeedsUpByItsForce) {
  const World::Body robot = AddRobot(Limited(50.0, 0.0, 0.0));
  world_.Get(drive_).Command({2.0, 0.0, 0.0});
  StepTimes(world_, 100);
  EXPECT_NEAR(SpeedOf(robot), 50.0 / 20.0 * 0.5, 1e-4);
  StepTimes(world_, 200);
  EXPECT_NEAR(SpeedOf(robot), 2.0, 1e-5);
}

// A torque of its own, and that of its friction at the radius of gyration.
TEST_F(GrippingRobot, TurnsUpByItsTorque) {
  const double inertia = 20.0 * 0.25 / 6.0;
  const double of_friction = 0.1 * 20.0 * kGravity * std::sqrt(inertia / 20.0);
  for (const auto& [settings, torque] :
       {std::pair{Limited(0.0, 0.5, 0.0), 0.5}, {Limited(0.0, 0.0, 0.1), of_friction}}) {
    const World::Body robot = AddRobot(settings);
    EXPECT_NEAR(world_.GetInertia(robot), inertia, 1e-4);
    world_.Get(drive_).Command({0.0, 0.0, 9.0});
    StepTimes(world_, 50);
    EXPECT_NEAR(world_.GetVelocity(robot).omega, torque / inertia * 0.25, 1e-3);
    world_.RemoveBody(robot);
  }
}

// With a force that is enough, it moves as without limits: within rounding, and far from the
// origin.
TEST_F(GrippingRobot, MovesAsOneWithoutLimitsIfItsForceIsEnough) {
  for (const Pose& start : {Pose{1.0, -2.0, 0.7}, Pose{50.0, -60.0, 0.0}}) {
    const World::Body robot = AddRobot(Limited(1e4, 1e4, 0.0), start);
    world_.AddCircle(robot, {0.2, 0.1}, 0.2, Solid());
    World free{10, 10};
    const World::Body other = AddBox(free, start, 0.5);
    free.AddCircle(other, {0.2, 0.1}, 0.2, Solid());
    const World::Drive drive = free.AddDrive(other, {0.5, 0.5, 0.0}, {});
    const World::Drive limited =
        world_.AddDrive(robot, {0.5, 0.5, 0.0}, {}, Limited(1e4, 1e4, 0.0));
    world_.RemoveBody(robot);  // a belt for each drive goes with it
    const World::Body body = AddBox(world_, start, 0.5);
    world_.AddCircle(body, {0.2, 0.1}, 0.2, Solid());
    drive_ = world_.AddDrive(body, {0.5, 0.5, 0.0}, {}, Limited(1e4, 1e4, 0.0));
    EXPECT_THROW(world_.Get(limited), GoneError);
    for (int i = 0; i < 1000; ++i) {
      const Twist twist{1.0, 0.1 * (i / 200), i < 500 ? 0.8 : -0.5};
      free.Get(drive).Command(twist);
      world_.Get(drive_).Command(twist);
      free.Step(kStep);
      world_.Step(kStep);
      const Pose a = free.GetPose(other), b = world_.GetPose(body);
      ASSERT_LT(std::hypot(a.x - b.x, a.y - b.y), 2e-4) << i;
      ASSERT_NEAR(free.GetLocalVelocity(other).vx, world_.GetLocalVelocity(body).vx, 1e-4) << i;
      ASSERT_NEAR(free.GetLocalVelocity(other).vy, world_.GetLocalVelocity(body).vy, 1e-4) << i;
    }
    world_.RemoveBody(body);
  }
  EXPECT_EQ(world_.body_count(), 0);
  EXPECT_EQ(world_.joint_count(), 0);
}

// A brake without commands holds a box by Coulomb's friction; the robot pushes with mu m g.
TEST_F(GrippingRobot, PushesABoxOnlyIfFrictionLetsIt) {
  const double mu = 0.5, force = mu * 20.0 * kGravity;
  for (const auto& [brake, moves] : {std::pair{1.01 * force, false}, {0.99 * force, true}}) {
    SCOPED_TRACE(brake / force);
    const World::Body box = AddRobot(Limited(brake, 1e4, 0.0), {0.55, 0.0, 0.0});
    const World::Body robot = AddRobot(Limited(0.0, 0.0, mu));
    world_.Get(drive_).Command({0.5, 0.0, 0.0});
    StepTimes(world_, 4000);  // 1 % of the force takes 10 s to stop both
    const double before = world_.GetPose(box).x;
    StepTimes(world_, 400);
    const double way = world_.GetPose(box).x - before;
    if (moves) {
      EXPECT_GT(way, 0.5);
    } else {
      EXPECT_LT(way, 1e-3);
    }
    world_.RemoveBody(box);
    world_.RemoveBody(robot);
  }
}

// Both together speed up by mu m g / (m + M).
TEST_F(GrippingRobot, PushesAFreeBoxByNewton) {
  const double mu = 0.3;
  FixtureSettings fixture = Dense(160.0);
  const World::Body box = AddBox(world_, {0.5, 0.0, 0.0}, 0.5, fixture);
  AddRobot(Limited(0.0, 0.0, mu));
  world_.Get(drive_).Command({20.0, 0.0, 0.0});
  StepTimes(world_, 20);
  const double before = SpeedOf(box);
  StepTimes(world_, 200);
  EXPECT_NEAR(SpeedOf(box) - before, mu * 20.0 * kGravity / 60.0 * 1.0, 0.01 * 0.98);
}

TEST_F(GrippingRobot, SlidesIfItIsPushedHarderThanItsFriction) {
  const double mu = 0.5, force = mu * 20.0 * kGravity;
  const World::Body robot = AddRobot(Limited(0.0, 0.0, mu));
  for (int i = 0; i < 200; ++i) {
    world_.ApplyForce(robot, {0.0, 0.99 * force});
    world_.Step(kStep);
  }
  EXPECT_NEAR(world_.GetPose(robot).y, 0.0, 1e-4);
  for (int i = 0; i < 200; ++i) {
    world_.ApplyForce(robot, {0.0, 1.2 * force});
    world_.Step(kStep);
  }
  EXPECT_NEAR(world_.GetVelocity(robot).vy, 0.2 * force / 20.0, 0.01);
  StepTimes(world_, 1000);
  EXPECT_NEAR(world_.GetVelocity(robot).vy, 0.0, 1e-6);
}

// At 2 m/s and 1 rad/s it needs 2 m/s^2 to the left: it drifts out of a curve with 0.15 g.
TEST_F(GrippingRobot, LeavesACurveThatIsTooFast) {
  for (const auto& [mu, holds] : {std::pair{0.25, true}, {0.15, false}}) {
    SCOPED_TRACE(mu);
    const World::Body robot = AddRobot(Limited(0.0, 1e3, mu));
    world_.SetVelocity(robot, {2.0, 0.0, 1.0});
    world_.Get(drive_).Command({2.0, 0.0, 1.0});
    StepTimes(world_, 600);
    const Pose pose = world_.GetPose(robot);
    const double away =
        std::hypot(pose.x - 2.0 * std::sin(3.0), pose.y - 2.0 * (1 - std::cos(3.0)));
    if (holds) {
      EXPECT_LT(away, 1e-3);
    } else {
      EXPECT_GT(away, 0.1);
    }
    world_.RemoveBody(robot);
  }
}

TEST_F(GrippingRobot, CarriesItsWheelsMass) {
  const World::Body robot = AddRobot(Limited(0.0, 0.0, 0.2));
  FixtureSettings load = Solid();
  load.density = 1000.0;  // 10 kg
  load.collides = false;
  const World::Body on_it = AddBox(world_, {0.0, 0.0, 0.0}, 0.1, load);
  world_.AddWeld(robot, on_it, {});
  world_.Get(drive_).Command({2.0, 0.0, 0.0});
  StepTimes(world_, 100);
  EXPECT_NEAR(SpeedOf(robot), 0.2 * kGravity * 0.5, 0.01 * 0.98);
}

TEST_F(GrippingRobot, IsDrivenAsBeforeWithAnotherCentreOfMass) {
  const World::Body robot = AddRobot(Limited(1e4, 1e4, 0.0));
  world_.SetMass(robot, 30.0, 2.0, Vec2{0.2, -0.1});
  world_.Get(drive_).Command({1.0, 0.0, 0.8});
  StepTimes(world_, 400);
  const Pose pose = world_.GetPose(robot);
  EXPECT_NEAR(pose.yaw, 1.6, 1e-3);
  EXPECT_NEAR(pose.x, std::sin(1.6) / 0.8, 2e-3);
  EXPECT_NEAR(pose.y, (1.0 - std::cos(1.6)) / 0.8, 2e-3);
}

TEST_F(GrippingRobot, MeasuresItsWheelsIfTheySlip) {
  world_.AddLayer({{{1.0, -5.0}, {1.0, 5.0}}}, kAllLayers);
  for (const auto& [settings, slips] : {std::pair{Limited(0.0, 0.0, 0.3), true},
                                        {Limited(40.0, 0.0, 0.0), false},
                                        {Limited(40.0, 0.0, 0.3), false},
                                        {Limited(400.0, 0.0, 0.3), true}}) {
    SCOPED_TRACE(testing::Message() << settings.force.max_force << " " << settings.force.friction);
    const World::Body robot = AddRobot(settings);
    const World::Drift odometry = world_.AddDrift(robot, {}, 0.0, 1);
    world_.Get(drive_).Command({0.5, 0.0, 0.0});
    StepTimes(world_, 2000);
    const double x = world_.GetPose(robot).x;
    EXPECT_NEAR(x, 0.75, 0.02);
    EXPECT_NEAR(world_.GetEstimate(odometry).x, slips ? 5.0 : x, 1e-4);
    EXPECT_NEAR(world_.Get(odometry).MeasuredVelocity().vx, slips ? 0.5 : 0.0, 2e-3);
    world_.SetPose(robot, {-1.0, 0.0, 0.0});  // a move is no error
    EXPECT_NEAR(world_.GetEstimate(odometry).x, (slips ? 5.0 : x) - 1.0 - x, 1e-4);
    world_.RemoveBody(robot);
  }
}

TEST_F(GrippingRobot, FallsAsleepAndIsWokenByACommand) {
  const World::Body robot = AddRobot(Limited(100.0, 0.0, 0.0));
  world_.Get(drive_).Command({0.5, 0.0, 0.0});
  StepTimes(world_, 100);
  world_.Get(drive_).Command({});
  StepTimes(world_, 200);
  EXPECT_FALSE(world_.IsAwake(robot));
  world_.Get(drive_).Command({0.5, 0.0, 0.0});
  StepTimes(world_, 100);
  EXPECT_NEAR(SpeedOf(robot), 0.5, 1e-5);
}

// A robot that touches a sensor is solved with the joint, one that touches nothing without it.
TEST_F(GrippingRobot, IsPulledByTheSameImpulseWithAndWithoutContacts) {
  BodySettings damped;
  damped.linear_damping = 0.5;
  damped.angular_damping = 0.8;
  for (const ActuatorSettings& settings :
       {Limited(30.0, 0.0, 0.0), Limited(0.0, 2.0, 0.3), Limited(1e4, 1e4, 0.0)}) {
    World world(10, 10);
    std::array<World::Body, 2> robots;
    std::array<World::Drive, 2> drives;
    for (int i = 0; i < 2; ++i) {
      damped.pose = {100.0 * i, 0.0, 0.3};
      robots[i] = world.AddBody(damped);
      FixtureSettings fixture = Dense(80.0);
      world.AddCircle(robots[i], {0.05, 0.02}, 0.3, fixture);
      drives[i] = world.AddDrive(robots[i], {}, {}, settings);
    }
    FixtureSettings zone = Solid();
    zone.sensor = true;
    world.AddCircle(world.AddBody({}), {}, 20.0, zone);
    for (int step = 0; step < 400; ++step) {
      for (int i = 0; i < 2; ++i) {
        world.Get(drives[i]).Command({1.0 - (step / 150) % 2, 0.3, 0.8 - 0.01 * (step % 90)});
        if (step % 7 == 0) world.ApplyForce(robots[i], {20.0, 5.0});
        if (step % 5 == 0) world.ApplyTorque(robots[i], 1.0);
      }
      world.Step(kStep);
      const Pose a = world.GetPose(robots[0]), b = world.GetPose(robots[1]);
      ASSERT_NEAR(a.x, b.x - 100.0, 1e-3) << step;
      ASSERT_NEAR(a.y, b.y, 1e-3) << step;
      ASSERT_NEAR(a.yaw, b.yaw, 1e-3) << step;
    }
  }
}

TEST_F(GrippingRobot, NeedsAMomentOfInertia) {
  for (const World::Body body : {AddPost(world_, {}), world_.AddBody({})}) {
    EXPECT_THROW(world_.AddDrive(body, {}, {}, Limited(1.0, 1.0, 1.0)), std::invalid_argument);
  }
  EXPECT_THROW(AddRobot(Limited(-1.0, 0.0, 0.0)), std::invalid_argument);
  EXPECT_EQ(world_.body_count(), 3);
}

/// Two robots of limited force that push a box and each other, between walls.
class PushingWorld {
 public:
  PushingWorld() {
    world_->AddLayer({{{2.0, -3.0}, {2.0, 3.0}}, {{-2.0, -3.0}, {-2.0, 3.0}}}, kAllLayers);
    for (const double y : {-0.3, 0.3}) {
      bodies_.push_back(AddBox(*world_, {-1.0, y, 0.0}, 0.4));
      drives_.push_back(world_->AddDrive(bodies_.back(), {1.0, 1.0, 0.0}, {},
                                         Limited(y > 0.0 ? 1.0 : 0.0, 0.0, 0.5)));
    }
    AddBox(*world_, {0.0, 0.0, 0.2}, 0.6);
    for (const World::Body body : bodies_)
      lidars_.push_back(world_->lidars().Add(body, LidarOf(0.0, 0.1, 1)));
  }
  static Twist CommandOf(int step, int robot) {
    return {1.0 - (step / 400) % 2, 0.0, 0.4 * robot - 0.2 * (step % 3)};
  }
  void Drive(World& world, int begin, int end) {
    for (int i = begin; i < end; ++i) {
      for (int k = 0; k < 2; ++k) world.Get(drives_[k]).Command(CommandOf(i, k));
      world.Step(kStep);
    }
  }

  std::unique_ptr<World> world_ = std::make_unique<World>(10, 10);
  std::vector<World::Body> bodies_;
  std::vector<World::Drive> drives_;
  std::vector<World::LidarHandle> lidars_;
};

TEST(GripState, IsSavedAndCopiedToTheLastBit) {
  PushingWorld pushing;
  World& world = *pushing.world_;
  int begin = 0;
  while (world.contacts().GetTouches().empty() && begin < 400) {
    pushing.Drive(world, begin, begin + 1);
    ++begin;
  }
  EXPECT_LT(begin, 400);
  const std::string saved = world.SaveState();
  const std::unique_ptr<World> copy = world.Copy();
  pushing.Drive(world, begin, 900);
  const std::string after = world.SaveState();
  pushing.Drive(*copy, begin, 900);
  EXPECT_EQ(copy->SaveState(), after);
  world.RestoreState(saved);
  EXPECT_EQ(world.SaveState(), saved);
  pushing.Drive(world, begin, 900);
  EXPECT_EQ(world.SaveState(), after);
}

TEST(GripState, IsThatOfEachEnvironmentOfABatch) {
  constexpr int kCount = 3;
  PushingWorld pushing;
  std::vector<BatchRobot> robots(2);
  for (int k = 0; k < 2; ++k) {
    robots[k].bodies = {pushing.bodies_[k]};
    robots[k].drive = pushing.drives_[k];
    robots[k].columns = {0, 1, 2};
    robots[k].action_size = 3;
    robots[k].lidar = pushing.lidars_[k];
  }
  WorldBatch batch(*pushing.world_, robots, kCount, 2);
  for (int step = 0; step < 500; ++step) {
    double actions[6 * kCount];
    for (int row = 0; row < 2 * kCount; ++row) {
      const Twist twist = PushingWorld::CommandOf(step, row % 2);
      actions[3 * row] = twist.vx;
      actions[3 * row + 1] = twist.vy;
      actions[3 * row + 2] = twist.omega;
    }
    batch.Advance(actions, 1, kStep);
  }
  pushing.Drive(*pushing.world_, 0, 500);
  for (int i = 0; i < kCount; ++i) EXPECT_EQ(batch.SaveState(i), pushing.world_->SaveState()) << i;
}

}  // namespace
}  // namespace flatland
