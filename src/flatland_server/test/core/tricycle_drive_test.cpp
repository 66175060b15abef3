#include "motion/tricycle_drive.hpp"

#include <gtest/gtest.h>

#include <stdexcept>

#include "reference_motion.hpp"
#include "test_bodies.hpp"
#include "test_numbers.hpp"
#include "world/world.hpp"

namespace flatland {
namespace {

constexpr double kWheelbase = 1.4;

double Apart(Vec2 a, Vec2 b) { return std::hypot(a.x - b.x, a.y - b.y); }

TricycleSettings WithAxleAt(Vec2 rear_axle) {
  TricycleSettings settings;
  settings.rear_axle = rear_axle;
  return settings;
}

TEST(TricycleDrive, RefusesAnAxleAtTheFrontWheelOrNowhere) {
  for (const Vec2 place : {Vec2{0, 0}, Vec2{1e-5, 0}, Vec2{kNaN, 0}, Vec2{0, -kInfinity}}) {
    EXPECT_THROW(TricycleDrive(WithAxleAt(place), nullptr), std::invalid_argument);
  }
}

TEST(TricycleDrive, RefusesLimitsThatAreNegativeOrNotFinite) {
  for (const double bad : {-0.1, kNaN, kInfinity}) {
    TricycleSettings angle = WithAxleAt({-1, 0}), speed = angle, rate = angle;
    angle.max_steer_angle = speed.linear.deceleration = rate.steering.velocity = bad;
    for (const TricycleSettings& settings : {angle, speed, rate}) {
      EXPECT_THROW(TricycleDrive(settings, nullptr), std::invalid_argument) << bad;
    }
  }
}

class Tricycle : public WorldTest {
 protected:
  // The robot of the documentation: its origin at the front wheel, which hangs on a hinge; two
  // wheels welded to it at the ends of its rear axle.
  void Build(const Pose& pose, const TricycleSettings& settings, const RevoluteSettings& hinge = {},
             bool wheel_is_b = true) {
    base_ = AddDisc(world_, pose, 0.3, Solid(),
                    {0.5 * settings.rear_axle.x, 0.5 * settings.rear_axle.y});
    const Vec2 left{-0.3 / kWheelbase * settings.rear_axle.y,
                    0.3 / kWheelbase * settings.rear_axle.x};
    for (const Vec2 place : {settings.rear_axle + left, settings.rear_axle - left}) {
      const Vec2 at = world_.ToWorldPoint(base_, place);
      const World::Body wheel = AddDisc(world_, {at.x, at.y, pose.yaw}, 0.1, Dense(1.8));
      world_.AddWeld(base_, wheel, WeldAt(place));
    }
    wheel_ = AddDisc(world_, pose, 0.1, Dense(1.8));  // a fifth of the base's mass
    hinge_ = wheel_is_b ? world_.AddRevolute(base_, wheel_, hinge)
                        : world_.AddRevolute(wheel_, base_, hinge);
    drive_ = world_.AddTricycle(base_, hinge_, settings);
  }

  void StepTimes(int steps) { flatland::StepTimes(world_, steps); }

  Vec2 FrontWheel() const {
    const Pose pose = world_.GetPose(base_);
    return {pose.x, pose.y};
  }

  // The angle of the front wheel's body, from straight ahead.
  double ShownAngle(double heading = 0.0) const {
    return AngleBetween(world_.GetPose(base_).yaw + heading, world_.GetPose(wheel_).yaw);
  }

  // All lines through the wheels' axles meet in one point; about it the robot turns.
  void ExpectCircle(double speed, double angle, const TricycleSettings& settings,
                    const Pose& pose = {2.0, -1.0, 0.4}) {
    Build(pose, settings);
    const Vec2 ahead = -1.0 / kWheelbase * settings.rear_axle;
    const Vec2 left{-ahead.y, ahead.x};
    const double axle_radius = kWheelbase / std::tan(angle);
    const Vec2 center = world_.ToWorldPoint(base_, settings.rear_axle + axle_radius * left);
    const Vec2 start = FrontWheel() - center;
    world_.Get(drive_).Command(speed, angle);

    for (int step = 1; step <= 2000; ++step) {
      world_.Step(kStep);

      const double turned = speed * std::sin(angle) / kWheelbase * step * kStep;
      const Vec2 expected = center + Rotation(turned).Apply(start);
      ASSERT_LT(Apart(FrontWheel(), expected), 1e-3) << "step " << step;
      ASSERT_NEAR(AngleBetween(pose.yaw + turned, world_.GetPose(base_).yaw), 0.0, 1e-3);
      const Vec2 axle = world_.ToWorldPoint(base_, settings.rear_axle);
      ASSERT_NEAR(Apart(axle, center), std::abs(axle_radius), 1e-3) << "step " << step;
      ASSERT_NEAR(Apart(FrontWheel(), center), std::abs(kWheelbase / std::sin(angle)), 1e-3);
      // The wheel rolls where it points, and the axle does not slip sideways.
      const Twist velocity = world_.GetLocalVelocity(base_);
      const Vec2 rolls = Rotation(angle).Apply(speed * ahead);
      ASSERT_NEAR(velocity.vx, rolls.x, 1e-3) << "step " << step;
      ASSERT_NEAR(velocity.vy, rolls.y, 1e-3) << "step " << step;
      const Vec2 slips = world_.ToLocalVector(base_, world_.GetVelocityAt(base_, axle));
      ASSERT_NEAR(Dot(slips, left), 0.0, 1e-3) << "step " << step;
    }
  }

  World::Body base_, wheel_;
  World::Joint hinge_;
  World::Tricycle drive_;
};

TEST_F(Tricycle, DrivesACircleAboutThePointWhereTheAxlesMeet) {
  ExpectCircle(0.6, 0.5, WithAxleAt({-kWheelbase, 0.0}));
  ExpectCircle(0.6, 0.5, WithAxleAt({-kWheelbase, 0.0}),
               {60.0, -80.0, 0.4});  // far from the origin
}

TEST_F(Tricycle, HeadsAwayFromItsAxleWhereverThatIs) {
  for (const double behind : {M_PI_2, -M_PI_2, 2.5, 0.0}) {
    SCOPED_TRACE(behind);
    ExpectCircle(0.6, 0.5,
                 WithAxleAt({kWheelbase * std::cos(behind), kWheelbase * std::sin(behind)}),
                 {4.0 * behind, 0.0, 0.4});
  }
}

// With its wheel across it, it turns about the middle of its rear axle.
TEST_F(Tricycle, TurnsOnTheSpotAboutItsAxle) {
  Build({0, 0, 0}, WithAxleAt({-kWheelbase, 0.0}));
  world_.Get(drive_).Command(0.7, M_PI_2);

  for (int step = 1; step <= 2000; ++step) {
    world_.Step(kStep);
    const Vec2 axle = world_.ToWorldPoint(base_, {-kWheelbase, 0.0});
    ASSERT_LT(Apart(axle, {-kWheelbase, 0.0}), 1e-3) << "step " << step;
  }
  EXPECT_NEAR(AngleBetween(5.0, world_.GetPose(base_).yaw), 0.0, 1e-3);
}

TEST_F(Tricycle, DrivesStraight) {
  Build({0, 0, M_PI_2}, WithAxleAt({-kWheelbase, 0.0}));
  world_.Get(drive_).Command(0.8, 0.0);

  StepTimes(2000);

  EXPECT_LT(Apart(FrontWheel(), {0.0, 8.0}), 1e-4);
}

// Speed up to 0.8 m/s within 2 s; steer to 0.984 rad: at 0.5 rad/s^2 to 0.4 rad/s, along it, and
// down at 1 rad/s^2. From 5 s on stop, and steer back to -0.2 rad.
TEST_F(Tricycle, FollowsItsLimitsInSpeedAndSteering) {
  const Course speed({{0, 0}, {2, 0.8}, {5, 0.8}, {6.6, 0.0}});
  const Course steering(
      {{0, 0}, {0.8, 0.4}, {2.66, 0.4}, {3.06, 0}, {5, 0}, {5.8, -0.4}, {8.16, -0.4}, {8.56, 0}});
  TricycleSettings settings = WithAxleAt({-kWheelbase, 0.0});
  settings.linear = {0.4, 0.5, 0.8};
  settings.steering = {0.5, 1.0, 0.4};
  Build({1, 2, 0.3}, settings);
  Pose expected{1, 2, 0.3};
  for (int step = 0; step < 2000; ++step) {
    const bool is_late = step >= 1000;
    world_.Get(drive_).Command(is_late ? 0.0 : 3.0, is_late ? -0.2 : 0.984);

    world_.Step(kStep);

    const double time = (step + 1) * kStep;
    const auto twist_at = [&](double t) {
      const double v = speed.At(t), angle = steering.Integral(t);
      return Twist{v * std::cos(angle), v * std::sin(angle), v * std::sin(angle) / kWheelbase};
    };
    expected = Travel(expected, time - kStep, time, twist_at);
    ASSERT_NEAR(world_.Get(drive_).speed(), speed.At(time), 1e-9) << "step " << step;
    ASSERT_NEAR(world_.Get(drive_).steer_angle(), steering.Integral(time), 1e-9) << step;
    ASSERT_NEAR(ShownAngle(), steering.Integral(time), 1e-5) << "step " << step;
    ExpectPose(world_.GetPose(base_), expected, 1e-3);
    if (HasFailure()) FAIL() << "step " << step;
    ExpectTwist(world_.GetLocalVelocity(base_), twist_at(time), 2e-3);
  }
}

TEST_F(Tricycle, ShowsTheAngleOnTheWheelsBody) {
  for (const bool wheel_is_b : {true, false}) {
    SCOPED_TRACE(wheel_is_b ? "wheel is b" : "wheel is a");
    TricycleSettings settings = WithAxleAt({-kWheelbase, 0.0});
    settings.steering = {0.0, 0.0, 0.5};
    settings.linear = {2.0, 2.0, 0.0};
    Build({0, wheel_is_b ? 0.0 : 9.0, 0.2}, settings, {}, wheel_is_b);
    world_.Get(drive_).Command(0.5, 0.8);

    for (int step = 1; step <= 400; ++step) {
      world_.Step(kStep);

      const double angle = std::min(0.8, 0.5 * step * kStep);
      ASSERT_NEAR(ShownAngle(), angle, 1e-5) << "step " << step;
      ASSERT_NEAR(world_.GetJointAngle(hinge_), wheel_is_b ? angle : -angle, 1e-5);
      // It stays on its hub, and moves with it.
      const Pose wheel = world_.GetPose(wheel_);
      ASSERT_LT(Apart({wheel.x, wheel.y}, FrontWheel()), 1e-6) << "step " << step;
      const Twist moves = world_.GetVelocity(wheel_), hub = world_.GetVelocity(base_);
      ASSERT_LT(Apart({moves.vx, moves.vy}, {hub.vx, hub.vy}), 1e-5) << "step " << step;
      ASSERT_EQ(moves.omega, hub.omega) << "step " << step;
    }
  }
}

TEST_F(Tricycle, ShowsTheAngleOnAWheelThatHangsElsewhere) {
  RevoluteSettings hinge;
  hinge.anchor_a = {0.1, 0.3};
  hinge.anchor_b = {0.0, -0.05};
  TricycleSettings settings = WithAxleAt({0.0, -kWheelbase});
  Build({0, 0, 0.2}, settings, hinge);
  world_.Get(drive_).Command(0.0, 0.6);

  StepTimes(100);

  EXPECT_NEAR(ShownAngle(M_PI_2), 0.6, 1e-5);
  EXPECT_LT(
      Apart(world_.ToWorldPoint(wheel_, {0.0, -0.05}), world_.ToWorldPoint(base_, {0.1, 0.3})),
      1e-5);
}

// The joint's limits apply to what is shown; the robot drives at the steering angle all the same.
TEST_F(Tricycle, ShowsNoMoreThanItsJointAllows) {
  for (const bool wheel_is_b : {true, false}) {
    SCOPED_TRACE(wheel_is_b ? "wheel is b" : "wheel is a");
    RevoluteSettings hinge;
    hinge.limits = wheel_is_b ? std::pair(-0.2, 0.3) : std::pair(-0.3, 0.2);
    Build({0, wheel_is_b ? 0.0 : 9.0, 0.2}, WithAxleAt({-kWheelbase, 0.0}), hinge, wheel_is_b);

    for (const double angle : {0.6, -0.6, 0.1}) {
      world_.Get(drive_).Command(0.1, angle);
      StepTimes(20);

      EXPECT_NEAR(ShownAngle(), std::clamp(angle, -0.2, 0.3), 1e-3);
      EXPECT_NEAR(world_.GetVelocity(base_).omega, 0.1 * std::sin(angle) / kWheelbase, 1e-3);
    }
  }
}

// The joint's limits may lie around an angle that is some whole rotations away.
TEST_F(Tricycle, ShowsTheAngleWithinLimitsWholeRotationsAway) {
  for (const double rotations : {-1.5, -0.5, 0.5, 1.5}) {
    for (const bool wheel_is_b : {true, false}) {
      SCOPED_TRACE(testing::Message() << rotations << " rotations, " << wheel_is_b);
      const double middle = 2.0 * M_PI * rotations;
      RevoluteSettings hinge;
      hinge.limits = std::pair(middle - 0.3, middle + 0.3);
      const Pose pose{0.0, 10.0 * rotations + 5.0 * wheel_is_b, 0.2};
      Build(pose, WithAxleAt({kWheelbase, 0.0}), hinge, wheel_is_b);
      world_.SetPose(wheel_, {pose.x, pose.y, pose.yaw});

      for (const double angle : {0.25, -0.25, 0.5}) {
        world_.Get(drive_).Command(0.1, angle);
        StepTimes(20);

        EXPECT_NEAR(ShownAngle(M_PI), std::clamp(angle, -0.3, 0.3), 1e-3);
        EXPECT_NEAR(world_.GetVelocity(base_).omega, 0.1 * std::sin(angle) / kWheelbase, 1e-3);
      }
    }
  }
}

TEST_F(Tricycle, DrivesOnWithoutItsWheel) {
  Build({0, 0, 0}, WithAxleAt({-kWheelbase, 0.0}));
  world_.Get(drive_).Command(0.6, 0.5);
  StepTimes(1000);

  world_.RemoveBody(wheel_);
  StepTimes(1000);

  const double turned = 0.6 * std::sin(0.5) / kWheelbase * 10.0;
  const Vec2 center{-kWheelbase, kWheelbase / std::tan(0.5)};
  EXPECT_LT(Apart(FrontWheel(), center + Rotation(turned).Apply(Vec2{} - center)), 1e-3);
  EXPECT_THROW(world_.GetJointAngle(hinge_), GoneError);
}

TEST_F(Tricycle, GoesWithItsBody) {
  Build({0, 0, 0}, WithAxleAt({-kWheelbase, 0.0}));
  world_.Get(drive_).Command(0.6, 0.5);
  StepTimes(10);

  world_.RemoveBody(base_);
  StepTimes(10);

  EXPECT_THROW(world_.Get(drive_), GoneError);
  EXPECT_TRUE(world_.Contains(wheel_));
}

TEST_F(Tricycle, RefusesACommandThatIsNotFiniteAndKeepsTheOldOne) {
  Build({0, 0, 0}, WithAxleAt({-kWheelbase, 0.0}));
  world_.Get(drive_).Command(0.6, 0.5);

  EXPECT_THROW(world_.Get(drive_).Command(kNaN, 0.0), std::invalid_argument);
  EXPECT_THROW(world_.Get(drive_).Command(0.0, kInfinity), std::invalid_argument);

  world_.Step(kStep);
  EXPECT_EQ(world_.Get(drive_).speed(), 0.6);
  EXPECT_EQ(world_.Get(drive_).steer_angle(), 0.5);
}

TEST_F(Tricycle, NeedsAHingeOfItsOwn) {
  Build({0, 0, 0}, WithAxleAt({-kWheelbase, 0.0}));
  const World::Body stranger = AddDisc(world_, {5, 5, 0}, 0.1, Solid());
  const World::Joint weld = world_.AddWeld(base_, stranger, {});
  const World::Joint other = world_.AddRevolute(wheel_, stranger, {});

  EXPECT_THROW(world_.AddTricycle(base_, weld, WithAxleAt({-1, 0})), std::invalid_argument);
  EXPECT_THROW(world_.AddTricycle(base_, other, WithAxleAt({-1, 0})), std::invalid_argument);
  EXPECT_THROW(world_.AddTricycle(base_, hinge_, WithAxleAt({0, 0})), std::invalid_argument);
  EXPECT_NO_THROW(world_.AddTricycle(base_, hinge_, WithAxleAt({-1, 0})));
}

}  // namespace
}  // namespace flatland
