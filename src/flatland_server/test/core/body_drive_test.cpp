#include "flatland_server/body_drive.hpp"

#include <gtest/gtest.h>

#include <limits>
#include <stdexcept>

#include "flatland_server/world.hpp"

namespace flatland {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
constexpr double kInfinity = std::numeric_limits<double>::infinity();

TEST(BodyDrive, RefusesLimitsThatAreNegativeOrNotFinite) {
  for (double bad : {-0.1, kNaN, kInfinity}) {
    for (const DynamicsLimits& limits :
         {DynamicsLimits{bad, 0.0, 0.0}, DynamicsLimits{0.0, bad, 0.0},
          DynamicsLimits{0.0, 0.0, bad}}) {
      EXPECT_THROW(BodyDrive(limits, {}), std::invalid_argument);
      EXPECT_THROW(BodyDrive({}, limits), std::invalid_argument);
    }
  }
}

TEST(BodyDrive, RefusesACommandThatIsNotFiniteAndKeepsTheOldOne) {
  BodyDrive drive;
  drive.Command({0.5, 0.1, 0.2});

  EXPECT_THROW(drive.Command({kNaN, 0.0, 0.0}), std::invalid_argument);
  EXPECT_THROW(drive.Command({0.0, kInfinity, 0.0}), std::invalid_argument);
  EXPECT_THROW(drive.Command({0.0, 0.0, kNaN}), std::invalid_argument);

  EXPECT_EQ(drive.target().vx, 0.5);
  EXPECT_EQ(drive.target().vy, 0.1);
  EXPECT_EQ(drive.target().omega, 0.2);
}

class DrivenRobot : public testing::Test {
 protected:
  static constexpr double kStep = 0.005;

  World::Body AddRobot(const Pose& pose) {
    BodySettings settings;
    settings.pose = pose;
    const World::Body robot = world_.AddBody(settings);
    FixtureSettings footprint;
    footprint.density = 1.0;
    // The centre of mass lies well off the origin.
    world_.AddCircle(robot, {0.3, 0.1}, 0.2, footprint);
    return robot;
  }

  // Where a frame is that has moved from `start` with a constant twist of its own.
  static Pose OnTheArc(const Pose& start, const Twist& twist, double time) {
    const double turned = twist.omega * time;
    const double s = std::sin(turned) / twist.omega;
    const double c = (1.0 - std::cos(turned)) / twist.omega;
    const Vec2 moved =
        Rotation(start.yaw).Apply({s * twist.vx - c * twist.vy, c * twist.vx + s * twist.vy});
    return {start.x + moved.x, start.y + moved.y, start.yaw + turned};
  }

  void ExpectArc(const Twist& twist) {
    const Pose start{1.0, -2.0, 0.7};
    const World::Body robot = AddRobot(start);
    world_.Get(world_.AddDrive(robot, {}, {})).Command(twist);

    for (int step = 1; step <= 2000; ++step) {
      world_.Step(kStep);

      const Pose pose = world_.GetPose(robot);
      const Pose expected = OnTheArc(start, twist, step * kStep);
      ASSERT_LT(std::hypot(pose.x - expected.x, pose.y - expected.y), 2e-4) << "step " << step;
      ASSERT_NEAR(std::remainder(pose.yaw - expected.yaw, 2.0 * M_PI), 0.0, 2e-4);
      const Twist velocity = world_.GetLocalVelocity(robot);
      ASSERT_NEAR(velocity.vx, twist.vx, 1e-5) << "step " << step;
      ASSERT_NEAR(velocity.vy, twist.vy, 1e-5) << "step " << step;
      ASSERT_NEAR(velocity.omega, twist.omega, 1e-5) << "step " << step;
    }
  }

  World world_{10, 10};
};

TEST_F(DrivenRobot, StaysOnTheArc) { ExpectArc({0.5, 0.0, 0.2}); }

TEST_F(DrivenRobot, StaysOnTheArcOfAnOmnidirectionalTwist) { ExpectArc({0.5, 0.3, 0.2}); }

TEST_F(DrivenRobot, StaysOnTheArcOfATurnToTheRight) { ExpectArc({0.5, -0.3, -0.8}); }

TEST_F(DrivenRobot, TurnsOnTheSpotAboutItsOrigin) { ExpectArc({0.0, 0.0, 1.0}); }

TEST_F(DrivenRobot, DrivesStraight) {
  const World::Body robot = AddRobot({0.0, 0.0, M_PI / 2});
  world_.Get(world_.AddDrive(robot, {}, {})).Command({0.4, 0.1, 0.0});

  for (int step = 0; step < 1000; ++step) world_.Step(kStep);

  const Pose pose = world_.GetPose(robot);
  EXPECT_NEAR(pose.x, -0.5, 2e-4);
  EXPECT_NEAR(pose.y, 2.0, 2e-4);
  EXPECT_NEAR(pose.yaw, M_PI / 2, 1e-6);
}

TEST_F(DrivenRobot, SpeedsUpAlongAStraightLineWithinTheLimits) {
  const World::Body robot = AddRobot({});
  const World::Drive drive = world_.AddDrive(robot, {1.0, 0.0, 0.0}, {2.0, 0.0, 0.0});
  world_.Get(drive).Command({5.0, -5.0, 5.0});

  for (int step = 0; step < 10; ++step) world_.Step(kStep);

  const Twist velocity = world_.Get(drive).velocity();
  EXPECT_NEAR(velocity.vx, 0.05 * M_SQRT1_2, 1e-12);
  EXPECT_NEAR(velocity.vy, -0.05 * M_SQRT1_2, 1e-12);
  EXPECT_NEAR(velocity.omega, 0.1, 1e-12);
}

TEST_F(DrivenRobot, StandsStillAfterAReset) {
  const World::Body robot = AddRobot({});
  BodyDrive& drive = world_.Get(world_.AddDrive(robot, {1.0, 1.0, 0.0}, {}));
  drive.Command({1.0, 0.0, 1.0});
  for (int step = 0; step < 10; ++step) world_.Step(kStep);

  drive.Reset();
  const Pose before = world_.GetPose(robot);
  world_.Step(kStep);

  const Pose after = world_.GetPose(robot);
  EXPECT_EQ(after.x, before.x);
  EXPECT_EQ(after.y, before.y);
  EXPECT_EQ(after.yaw, before.yaw);
  EXPECT_EQ(drive.target().vx, 0.0);
  EXPECT_EQ(drive.velocity().vx, 0.0);
}

}  // namespace
}  // namespace flatland
