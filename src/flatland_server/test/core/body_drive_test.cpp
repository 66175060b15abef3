#include "motion/body_drive.hpp"

#include <gtest/gtest.h>

#include <stdexcept>
#include <vector>

#include "reference_motion.hpp"
#include "test_bodies.hpp"
#include "test_numbers.hpp"
#include "world/world.hpp"

namespace flatland {
namespace {

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

  ExpectTwist(drive.target(), {0.5, 0.1, 0.2}, 0.0);
}

class DrivenRobot : public WorldTest {
 protected:
  // Its centre of mass lies well off its origin.
  World::Body AddRobot(const Pose& pose) { return AddDisc(world_, pose, 0.2, Solid(), {0.3, 0.1}); }

  // Four wheels of a fifth of the robot's mass each: two are welded to it, two turn on it freely.
  void AddWheels(World::Body robot) {
    for (const Vec2 place : {Vec2{-0.1, 0.4}, {-0.1, -0.2}, {0.6, 0.4}, {0.6, -0.2}}) {
      const Vec2 at = world_.ToWorldPoint(robot, place);
      const Pose pose{at.x, at.y, world_.GetPose(robot).yaw};
      const World::Body wheel = AddDisc(world_, pose, 0.1, Dense(0.8));
      EXPECT_NEAR(world_.GetMass(wheel) / world_.GetMass(robot), 0.2, 1e-6);
      RevoluteSettings hinge;
      hinge.anchor_a = place;
      if (place.x < 0.0) world_.AddWeld(robot, wheel, WeldAt(place));
      if (place.x >= 0.0) world_.AddRevolute(robot, wheel, hinge);
    }
  }

  // Steps the world for 10 s. At each step, expects the robot at the velocity `twist_at(time)`, in
  // its frame, and at the pose to which these velocities lead.
  template <class TwistAt>
  void ExpectTravel(World::Body robot, double step_length, double place_tolerance,
                    double velocity_tolerance, TwistAt twist_at) {
    Pose expected = world_.GetPose(robot);
    for (int step = 1; step * step_length < 10.0 + 1e-9; ++step) {
      world_.Step(step_length);

      const double time = step * step_length;
      expected = Travel(expected, time - step_length, time, twist_at);
      SCOPED_TRACE(step);
      ExpectPose(world_.GetPose(robot), expected, place_tolerance);
      ExpectTwist(world_.GetLocalVelocity(robot), twist_at(time), velocity_tolerance);
      if (HasFailure()) return;
    }
  }

  World world_{10, 10};
};

TEST_F(DrivenRobot, StaysOnTheArc) {
  for (const Twist& twist : {Twist{0.5, 0.0, 0.2}, {0.5, 0.3, 0.2}, {0.5, -0.3, -0.8}, {0, 0, 1}}) {
    // Far from the origin, the position is rounded by up to 2 um in each step, to the same side.
    for (const Pose& start : {Pose{1.0, -2.0, 0.7}, Pose{50, -60, 0}}) {
      SCOPED_TRACE(testing::Message() << twist.vx << " " << twist.vy << " from " << start.x);
      const World::Body robot = AddRobot(start);
      world_.Get(world_.AddDrive(robot, {}, {})).Command(twist);
      ExpectTravel(robot, kStep, 2e-5, 1e-5, [&](double) { return twist; });
      world_.RemoveBody(robot);
    }
  }
}

TEST_F(DrivenRobot, DrivesStraight) {
  const World::Body robot = AddRobot({0.0, 0.0, M_PI / 2});
  world_.Get(world_.AddDrive(robot, {}, {})).Command({0.4, 0.1, 0.0});

  StepTimes(world_, 1000);

  ExpectPose(world_.GetPose(robot), {-0.5, 2.0, M_PI / 2}, 2e-4);
  EXPECT_NEAR(world_.GetPose(robot).yaw, M_PI / 2, 1e-6);
  const World::Body far = AddRobot({50.0, 40.0, 0.0});
  world_.Get(world_.AddDrive(far, {}, {})).Command({0.8, 0.0, 0.0});
  StepTimes(world_, 2000);
  EXPECT_NEAR(world_.GetPose(far).x, 58.0, 2e-5);
}

// Up to the limit of 0.8 m/s at 0.2 m/s^2, along it, and from 6 s on down and back.
const Course kSpeed({{0, 0}, {4, 0.8}, {6, 0.8}, {8, 0}, {11, -0.6}});
const DynamicsLimits kSpeedLimits{0.2, 0.4, 0.8};
// Up to the limit of 1 rad/s in 2 s, and from 6 s on down.
const Course kTurning({{0, 0}, {2, 1}, {6, 1}, {7.25, 0}});
const DynamicsLimits kTurningLimits{0.5, 0.8, 1.0};

class LimitedRobot : public DrivenRobot {
 protected:
  // Gives the commands that kSpeed and kTurning follow: one now, one after 6 s.
  void ExpectCourses(const Twist& first, const Twist& then, double step_length,
                     double place_tolerance, double velocity_tolerance) {
    const World::Drive drive = world_.AddDrive(robot_, kSpeedLimits, kTurningLimits);
    world_.Get(drive).Command(first);
    ExpectTravel(robot_, step_length, place_tolerance, velocity_tolerance, [&](double time) {
      if (time >= 6.0 - 1e-9) world_.Get(drive).Command(then);
      return Twist{first.vx != 0.0 ? kSpeed.At(time) : 0.0, 0.0,
                   first.omega != 0.0 ? kTurning.At(time) : 0.0};
    });
  }

  World::Body robot_ = AddRobot({1.0, -2.0, 0.7});
};

// The acceleration changes within steps of 7.5 and 30 ms.
TEST_F(LimitedRobot, FollowsItsRampOnAStraightLine) {
  for (const double step_length : {0.005, 0.0075, 0.03}) {
    SCOPED_TRACE(step_length);
    ExpectCourses({5, 0, 0}, {-3, 0, 0}, step_length, 1e-4, 1e-5);
    world_.RemoveBody(robot_);
    robot_ = AddRobot({1.0, -2.0, 0.7});
  }
}

TEST_F(LimitedRobot, FollowsItsArcsWithBothVelocitiesLimited) {
  ExpectCourses({5, 0, 5}, {-3, 0, 0}, 0.005, 1e-4, 1e-5);
}

TEST_F(LimitedRobot, FollowsItsRampWithWheels) {
  AddWheels(robot_);
  ExpectCourses({5, 0, 0}, {-3, 0, 0}, 0.005, 1e-4, 1e-4);
}

TEST_F(LimitedRobot, FollowsItsArcsWithWheels) {
  AddWheels(robot_);
  ExpectCourses({5, 0, 5}, {-3, 0, 0}, 0.005, 1e-3, 1e-3);
}

TEST_F(DrivenRobot, StaysOnTheArcWithWheels) {
  const World::Body robot = AddRobot({1.0, -2.0, 0.7});
  AddWheels(robot);
  world_.Get(world_.AddDrive(robot, {}, {})).Command({0.5, 0.3, -0.8});

  ExpectTravel(robot, 0.005, 1e-3, 1e-3, [](double) { return Twist{0.5, 0.3, -0.8}; });
}

// The velocity of a vector (0.6, 0.8) grows along it; kSpeed is its length.
TEST_F(LimitedRobot, FollowsItsRampInADirectionOfItsOwn) {
  const World::Drive drive = world_.AddDrive(robot_, kSpeedLimits, {});
  world_.Get(drive).Command({3, 4, 0});

  ExpectTravel(robot_, 0.005, 1e-4, 1e-5, [&](double time) {
    if (time >= 6.0 - 1e-9) world_.Get(drive).Command({-3, -4, 0});
    return Twist{0.6 * kSpeed.At(time), 0.8 * kSpeed.At(time), 0.0};
  });
}

// A spring yields, and swings, on a driven body as on any other.
TEST_F(DrivenRobot, LetsASpringSwing) {
  const World::Body robot = AddRobot({});
  const World::Body arm = world_.AddBody({});
  world_.AddCircle(arm, {0.0, 0.0}, 0.1, {0.01, 0.0, 0.0, false, false});
  WeldSettings spring;
  spring.frequency = 1.0;
  const World::Joint joint = world_.AddWeld(robot, arm, spring);
  world_.Get(world_.AddDrive(robot, {}, {})).Command({0.5, 0.0, 0.0});
  world_.SetVelocity(arm, {0.0, 0.0, 1.0});

  double least = 0.0, most = 0.0;
  for (int step = 0; step < 200; ++step) {
    world_.Step(kStep);
    least = std::min(least, world_.GetJointAngle(joint));
    most = std::max(most, world_.GetJointAngle(joint));
  }

  // An amplitude of 1 rad/s over 2 pi 1/s, less what an implicit spring loses.
  EXPECT_GT(most, 0.1);
  EXPECT_LT(least, -0.1);
}

// Damping must not count as an obstacle. Box2D divides by 1 + damping * dt in every step.
TEST_F(DrivenRobot, IsAsFastAsItsDampingLetsIt) {
  const World::Body robot = world_.AddBody({b2_dynamicBody, {}, 8.0, 4.0});
  world_.AddCircle(robot, {0.0, 0.0}, 0.2, Solid());
  world_.Get(world_.AddDrive(robot, {}, {})).Command({0.5, 0.0, 1.0});

  StepTimes(world_, 100);

  const Twist velocity = world_.GetLocalVelocity(robot);
  EXPECT_NEAR(velocity.vx, 0.5 / (1.0 + 8.0 * kStep), 1e-4);
  EXPECT_NEAR(velocity.omega, 1.0 / (1.0 + 4.0 * kStep), 1e-6);
}

class RobotAtAWall : public DrivenRobot {
 protected:
  RobotAtAWall() { world_.AddLayer({{{2.0, -100.0}, {2.0, 100.0}}}, 0xFFFF); }

  // Regardless of its reported velocity, it does not come nearer to the wall.
  void ExpectNoPhantomVelocity(const DynamicsLimits& limits, double heading) {
    const World::Body robot = AddDisc(world_, {1.0, -50.0, heading}, 0.3, Solid(), {0.05, 0.0});
    world_.Get(world_.AddDrive(robot, limits, {})).Command({1.0, 0.0, 0.0});
    const double until_it_is_there = 2.0 + 1.0 / std::cos(heading);
    for (int step = 0; step * kStep < 10.0 + until_it_is_there; ++step) world_.Step(kStep);

    const double x = world_.GetCenter(robot).x;
    EXPECT_NEAR(x, 1.7, 0.02);  // Box2D's skins and slop
    double fastest = 0.0, before = x;
    for (int step = 0; step < 400; ++step) {
      world_.Step(kStep);
      const double moved = (world_.GetCenter(robot).x - before) / kStep;
      before = world_.GetCenter(robot).x;
      fastest = std::max(fastest, std::abs(world_.GetVelocity(robot).vx - moved));
      ASSERT_NEAR(before, x, 5e-4) << "step " << step;
      ASSERT_NEAR(world_.GetVelocity(robot).vy, std::sin(heading), 0.01) << "step " << step;
    }
    EXPECT_LT(fastest, 0.01);
    world_.RemoveBody(robot);
  }
};

// Nor the velocity that a step of acceleration would add.
TEST_F(RobotAtAWall, HasNoPhantomVelocityWhileItWouldSpeedUp) {
  const World::Body robot = AddDisc(world_, {1.705, 0.0, 0.0}, 0.3);
  world_.Get(world_.AddDrive(robot, {10.0, 10.0, 0.0}, {})).Command({1.0, 0.0, 0.0});

  for (int step = 0; step < 40; ++step) {
    world_.Step(kStep);
    ASSERT_LT(std::abs(world_.GetVelocity(robot).vx), 0.01) << "step " << step;
  }
  EXPECT_NEAR(world_.GetPose(robot).x, 1.7, 0.01);
}

TEST_F(RobotAtAWall, HasNoPhantomVelocityTowardsItAndAlongIt) {
  for (const double heading : {0.0, 1.55, 1.52, 1.48, 1.3, 0.8, -0.8, -1.5}) {
    for (const double acceleration : {0.0, 0.1, 0.3, 5.0}) {
      SCOPED_TRACE(testing::Message() << heading << " rad, " << acceleration << " m/s^2");
      ExpectNoPhantomVelocity({acceleration, acceleration, 0.0}, heading);
    }
  }
}

TEST_F(DrivenRobot, StandsStillAfterAReset) {
  const World::Body robot = AddRobot({});
  BodyDrive& drive = world_.Get(world_.AddDrive(robot, {1.0, 1.0, 0.0}, {}));
  drive.Command({1.0, 0.0, 1.0});
  StepTimes(world_, 10);

  drive.Reset();
  const Pose before = world_.GetPose(robot);
  world_.Step(kStep);

  const Pose after = world_.GetPose(robot);
  EXPECT_EQ(after, before);
  ExpectTwist(drive.target(), {}, 0.0);
  ExpectTwist(drive.velocity(), {}, 0.0);
}

}  // namespace
}  // namespace flatland
