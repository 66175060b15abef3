#include "flatland_server/world.hpp"

#include <gtest/gtest.h>

#include <functional>
#include <limits>
#include <ostream>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

namespace flatland {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
constexpr double kInfinity = std::numeric_limits<double>::infinity();
// A finite number that single precision, and so Box2D, has no place for.
constexpr double kTooMuch = 1e39;
constexpr double kStep = 0.005;

FixtureSettings Solid() {
  FixtureSettings settings;
  settings.density = 1.0;
  return settings;
}

std::vector<Vec2> Square(double side) {
  const double h = side / 2;
  return {{-h, -h}, {h, -h}, {h, h}, {-h, h}};
}

BodySettings At(const Pose& pose, b2BodyType type = b2_dynamicBody) {
  BodySettings settings;
  settings.type = type;
  settings.pose = pose;
  return settings;
}

World::Body AddBox(World& world, const Pose& pose, double side = 1.0,
                   const FixtureSettings& fixture = Solid()) {
  const World::Body box = world.AddBody(At(pose));
  world.AddPolygon(box, Square(side), fixture);
  return box;
}

World::Body AddPost(World& world, const Pose& pose) {
  return world.AddBody(At(pose, b2_staticBody));
}

void StepTimes(World& world, int steps) {
  for (int step = 0; step < steps; ++step) world.Step(kStep);
}

double Turn(double from, double to) { return std::remainder(to - from, 2.0 * M_PI); }

void ExpectPose(const Pose& pose, const Pose& expected, double tolerance) {
  EXPECT_NEAR(pose.x, expected.x, tolerance);
  EXPECT_NEAR(pose.y, expected.y, tolerance);
  EXPECT_NEAR(Turn(expected.yaw, pose.yaw), 0.0, tolerance);
}

void ExpectTwist(const Twist& twist, const Twist& expected, double tolerance) {
  EXPECT_NEAR(twist.vx, expected.vx, tolerance);
  EXPECT_NEAR(twist.vy, expected.vy, tolerance);
  EXPECT_NEAR(twist.omega, expected.omega, tolerance);
}

FixtureSettings OnLayers(LayerBits layers) {
  FixtureSettings settings = Solid();
  settings.layers = layers;
  return settings;
}

FixtureSettings Ghost() {
  FixtureSettings settings = Solid();
  settings.collides = false;
  return settings;
}

FixtureSettings Sensor() {
  FixtureSettings settings = Solid();
  settings.sensor = true;
  return settings;
}

struct Meeting {
  const char* name;
  FixtureSettings moving;
  FixtureSettings waiting;
  bool collide;
};

void PrintTo(const Meeting& meeting, std::ostream* out) { *out << meeting.name; }

class Collision : public testing::TestWithParam<Meeting> {};

TEST_P(Collision, OfABoxPushedAtAnother) {
  World world(10, 10);
  const World::Body moving = AddBox(world, {0, 0, 0}, 1.0, GetParam().moving);
  const World::Body waiting = AddBox(world, {2, 0, 0}, 1.0, GetParam().waiting);
  world.SetVelocity(moving, {2, 0, 0});

  StepTimes(world, 400);

  if (GetParam().collide) {
    EXPECT_GT(world.GetPose(waiting).x, 2.5);
    EXPECT_LT(world.GetPose(moving).x, world.GetPose(waiting).x - 0.9);
  } else {
    EXPECT_NEAR(world.GetPose(moving).x, 4.0, 1e-4);
    EXPECT_EQ(world.GetPose(waiting).x, 2.0);
  }
}

INSTANTIATE_TEST_SUITE_P(
    Meetings, Collision,
    testing::Values(Meeting{"all_layers_collide", Solid(), Solid(), true},
                    Meeting{"one_shared_layer_collides", OnLayers(0b011), OnLayers(0b110), true},
                    Meeting{"highest_layer_collides", OnLayers(0x8000), OnLayers(0x8000), true},
                    Meeting{"no_shared_layer_passes", OnLayers(0b001), OnLayers(0b110), false},
                    Meeting{"no_layers_pass", OnLayers(0), Solid(), false},
                    Meeting{"not_colliding_passes", Ghost(), Solid(), false},
                    Meeting{"passes_what_does_not_collide", Solid(), Ghost(), false},
                    Meeting{"sensor_passes", Sensor(), Solid(), false},
                    Meeting{"passes_a_sensor", Solid(), Sensor(), false}),
    [](const testing::TestParamInfo<Meeting>& info) { return info.param.name; });

class WorldTest : public testing::Test {
 protected:
  World world_{10, 10};
};

TEST_F(WorldTest, WallStopsOnlyItsLayers) {
  world_.AddLayer({{{2, -5}, {2, 5}}}, 0b10);
  const World::Body stopped = AddBox(world_, {0, 0, 0}, 1.0, OnLayers(0b10));
  const World::Body passing = AddBox(world_, {0, 3, 0}, 1.0, OnLayers(0b01));
  world_.SetVelocity(stopped, {2, 0, 0});
  world_.SetVelocity(passing, {2, 0, 0});

  StepTimes(world_, 400);

  EXPECT_LT(world_.GetPose(stopped).x, 1.6);
  EXPECT_NEAR(world_.GetPose(passing).x, 4.0, 1e-4);
}

TEST_F(WorldTest, WallStopsFromBothSides) {
  world_.AddLayer({{{0, -5}, {0, 5}}}, 0xFFFF);
  const World::Body left = AddBox(world_, {-2, 0, 0});
  const World::Body right = AddBox(world_, {2, 0, 0});
  world_.SetVelocity(left, {2, 0, 0});
  world_.SetVelocity(right, {-2, 0, 0});

  StepTimes(world_, 400);

  EXPECT_LT(world_.GetPose(left).x, -0.4);
  EXPECT_GT(world_.GetPose(right).x, 0.4);
}

// The box is shorter than what it moves in a step.
TEST_F(WorldTest, FastBoxDoesNotPassThroughAWall) {
  world_.AddLayer({{{3.03, -5}, {3.03, 5}}}, 0xFFFF);
  const World::Body box = AddBox(world_, {0, 0, 0}, 0.04);
  world_.SetVelocity(box, {20, 0, 0});

  StepTimes(world_, 400);

  EXPECT_LT(world_.GetPose(box).x, 3.03);
  EXPECT_GT(world_.GetPose(box).x, 2.9);
}

TEST_F(WorldTest, DrivenBoxDoesNotPassThroughAWall) {
  world_.AddLayer({{{3.03, -5}, {3.03, 5}}}, 0xFFFF);
  const World::Body box = AddBox(world_, {0, 0, 0}, 0.4);
  world_.Get(world_.AddDrive(box, {}, {})).Command({20, 0, 0});

  StepTimes(world_, 400);

  EXPECT_LT(world_.GetPose(box).x, 3.03);
}

TEST_F(WorldTest, RevoluteLimitsHoldUnderTorque) {
  const World::Body post = AddPost(world_, {0, 0, 0});
  const World::Body arm = AddBox(world_, {0, 0, 0});
  RevoluteSettings settings;
  settings.limits = {{-0.5, 0.8}};
  const World::Joint hinge = world_.AddRevolute(post, arm, settings);

  for (const double torque : {3.0, -3.0}) {
    for (int step = 0; step < 600; ++step) {
      world_.ApplyTorque(arm, torque);
      world_.Step(kStep);
      ASSERT_GT(world_.JointAngle(hinge), -0.52);
      ASSERT_LT(world_.JointAngle(hinge), 0.82);
    }
    EXPECT_NEAR(world_.JointAngle(hinge), torque > 0 ? 0.8 : -0.5, 0.02);
  }
}

TEST_F(WorldTest, RevoluteHoldsTheAnchorsTogether) {
  const World::Body post = AddPost(world_, {1, 1, 0});
  const World::Body arm = AddBox(world_, {1, 2, 0});
  RevoluteSettings settings;
  settings.anchor_b = {0, -1};
  world_.AddRevolute(post, arm, settings);
  world_.SetVelocity(arm, {1, 0, 0});

  double turned = 0.0;
  for (int step = 0; step < 400; ++step) {
    const double before = world_.GetPose(arm).yaw;
    world_.Step(kStep);
    const Pose pose = world_.GetPose(arm);
    turned += Turn(before, pose.yaw);
    const Vec2 anchor = Vec2{pose.x, pose.y} + Rotation(pose.yaw).Apply({0, -1});
    ASSERT_NEAR(anchor.x, 1.0, 0.005);
    ASSERT_NEAR(anchor.y, 1.0, 0.005);
  }
  EXPECT_LT(turned, -1.0);
}

TEST_F(WorldTest, RigidWeldHolds) {
  const World::Body a = AddBox(world_, {0, 0, 0}, 0.4);
  const World::Body b = AddBox(world_, {1, 0, 0.3}, 0.4);
  WeldSettings settings;
  settings.anchor_a = {1, 0};
  settings.angle = 0.3;
  const World::Joint weld = world_.AddWeld(a, b, settings);

  for (int step = 0; step < 400; ++step) {
    world_.ApplyForce(b, {0.2, 0.5});
    world_.ApplyTorque(b, 0.2);
    world_.Step(kStep);
    const Pose pa = world_.GetPose(a), pb = world_.GetPose(b);
    ASSERT_NEAR(world_.JointAngle(weld), 0.0, 0.01);
    const Vec2 apart = Rotation(pa.yaw).ApplyInverse({pb.x - pa.x, pb.y - pa.y});
    ASSERT_NEAR(apart.x, 1.0, 0.01);
    ASSERT_NEAR(apart.y, 0.0, 0.01);
  }
  EXPECT_GT(std::abs(world_.GetPose(a).yaw), 0.1);
}

TEST_F(WorldTest, SoftWeldYields) {
  const World::Body post = AddPost(world_, {0, 0, 0});
  const World::Body arm = AddBox(world_, {0, 0, 0});
  WeldSettings settings;
  settings.frequency = 1.0;
  settings.damping = 1.0;
  const World::Joint weld = world_.AddWeld(post, arm, settings);

  for (int step = 0; step < 1000; ++step) {
    world_.ApplyTorque(arm, 1.0);
    world_.Step(kStep);
  }
  // A spring of stiffness I (2 pi f)^2, with I = 1/6 kg m^2 for a square of 1 m and 1 kg.
  EXPECT_NEAR(world_.JointAngle(weld), 6.0 / (4.0 * M_PI * M_PI), 0.01);

  StepTimes(world_, 1000);
  EXPECT_NEAR(world_.JointAngle(weld), 0.0, 0.01);
}

// The arm swings about a hinge beside the post, and after half a turn over the post.
TEST_F(WorldTest, JointedBodiesCollideOnlyIfToldTo) {
  for (const bool collide : {false, true}) {
    World world(10, 10);
    const World::Body post = AddPost(world, {0, 0, 0});
    world.AddPolygon(post, Square(1), Solid());
    const World::Body arm = AddBox(world, {1.6, 0, 0}, 0.4);
    RevoluteSettings settings;
    settings.anchor_a = {0.8, 0};
    settings.anchor_b = {-0.8, 0};
    settings.collide_connected = collide;
    world.AddRevolute(post, arm, settings);
    world.SetVelocity(arm, {0, 1.6, 2});

    StepTimes(world, 314);

    const Pose pose = world.GetPose(arm);
    const bool over_the_post = std::hypot(pose.x, pose.y) < 0.2;
    EXPECT_EQ(over_the_post, !collide);
  }
}

TEST_F(WorldTest, JointAngleIsThatOfBLessThatOfA) {
  const World::Body a = AddBox(world_, {0, 0, 3.0});
  const World::Body b = AddBox(world_, {0, 0, -3.0});

  EXPECT_NEAR(world_.JointAngle(world_.AddRevolute(a, b, {})), 2.0 * M_PI - 6.0, 1e-6);
  EXPECT_NEAR(world_.JointAngle(world_.AddRevolute(b, a, {})), 6.0 - 2.0 * M_PI, 1e-6);
  WeldSettings weld;
  weld.angle = 0.2;
  EXPECT_NEAR(world_.JointAngle(world_.AddWeld(a, b, weld)), 2.0 * M_PI - 6.2, 1e-6);
}

TEST_F(WorldTest, RemovedBodyTakesItsJointsAndDrivesWithIt) {
  const World::Body a = AddBox(world_, {0, 0, 0});
  const World::Body b = AddBox(world_, {2, 0, 0});
  const World::Body c = AddBox(world_, {4, 0, 0});
  const World::Joint hinge = world_.AddRevolute(a, b, {});
  const World::Joint weld = world_.AddWeld(b, c, {});
  const World::Joint other = world_.AddRevolute(a, c, {});
  const World::Drive drive_a = world_.AddDrive(a, {}, {});
  const World::Drive drive_b = world_.AddDrive(b, {}, {});
  const World::Drive second_drive_b = world_.AddDrive(b, {}, {});

  world_.RemoveBody(b);

  EXPECT_EQ(world_.body_count(), 2);
  EXPECT_EQ(world_.joint_count(), 1);
  EXPECT_FALSE(world_.Contains(b));
  EXPECT_FALSE(world_.Contains(hinge));
  EXPECT_THROW(world_.JointAngle(hinge), GoneError);
  EXPECT_THROW(world_.JointAngle(weld), GoneError);
  EXPECT_THROW(world_.Get(drive_b), GoneError);
  EXPECT_THROW(world_.Get(second_drive_b), GoneError);
  EXPECT_NO_THROW(world_.JointAngle(other));
  EXPECT_NO_THROW(world_.Get(drive_a));
  StepTimes(world_, 10);
}

TEST_F(WorldTest, NothingCanBeDoneWithARemovedBody) {
  const World::Body gone = AddBox(world_, {0, 0, 0});
  world_.RemoveBody(gone);
  const World::Body here = AddBox(world_, {0, 0, 0});
  ASSERT_EQ(here.index, gone.index);

  EXPECT_THROW(world_.RemoveBody(gone), GoneError);
  EXPECT_THROW(world_.AddCircle(gone, {0, 0}, 1.0, {}), GoneError);
  EXPECT_THROW(world_.AddPolygon(gone, Square(1), {}), GoneError);
  EXPECT_THROW(world_.AddRevolute(gone, here, {}), GoneError);
  EXPECT_THROW(world_.AddWeld(here, gone, {}), GoneError);
  EXPECT_THROW(world_.AddDrive(gone, {}, {}), GoneError);
  EXPECT_THROW(world_.GetPose(gone), GoneError);
  EXPECT_THROW(world_.SetPose(gone, {}), GoneError);
  EXPECT_THROW(world_.GetVelocity(gone), GoneError);
  EXPECT_THROW(world_.SetVelocity(gone, {}), GoneError);
  EXPECT_THROW(world_.GetLocalVelocity(gone), GoneError);
  EXPECT_THROW(world_.Halt(gone), GoneError);
  EXPECT_THROW(world_.GetMass(gone), GoneError);
  EXPECT_THROW(world_.ApplyForce(gone, {1, 0}), GoneError);
  EXPECT_THROW(world_.ApplyTorque(gone, 1), GoneError);
  EXPECT_THROW(world_.ApplyLinearImpulse(gone, {1, 0}), GoneError);
  EXPECT_THROW(world_.ApplyAngularImpulse(gone, 1), GoneError);
  EXPECT_THROW(world_.GetVelocityAt(gone, {0, 0}), GoneError);
  EXPECT_THROW(world_.GetInertia(gone), GoneError);
  EXPECT_THROW(world_.GetCenter(gone), GoneError);
  EXPECT_THROW(world_.IsAwake(gone), GoneError);
  EXPECT_THROW(world_.ToWorldPoint(gone, {0, 0}), GoneError);
  EXPECT_THROW(world_.ToLocalVector(gone, {0, 0}), GoneError);
  EXPECT_THROW(world_.GetFixtureCount(gone), GoneError);
  EXPECT_THROW(world_.GetSettings({gone, 0}), GoneError);
  EXPECT_THROW(world_.SetFriction({gone, 0}, 0.5), GoneError);
  EXPECT_THROW(world_.TestPoint({gone, 0}, {0, 0}), GoneError);
  EXPECT_THROW(world_.AddTricycle(gone, {}, {}), GoneError);
  EXPECT_THROW(world_.ListenTo(gone, kBeginContact), GoneError);
}

TEST_F(WorldTest, BodyInARemovedOnesPlaceHasNotItsDrive) {
  const World::Body a = AddBox(world_, {0, 0, 0});
  const World::Body b = AddBox(world_, {2, 0, 0});
  world_.Get(world_.AddDrive(b, {}, {})).Command({1, 0, 0});
  world_.RemoveBody(b);
  const World::Body c = AddBox(world_, {4, 0, 0});

  StepTimes(world_, 100);

  ExpectPose(world_.GetPose(a), {0, 0, 0}, 0.0);
  ExpectPose(world_.GetPose(c), {4, 0, 0}, 0.0);
}

TEST_F(WorldTest, HaltStopsABody) {
  const World::Body box = AddBox(world_, {0, 0, 0});
  const World::Body other = AddBox(world_, {0, 5, 0});
  world_.SetVelocity(box, {1, 0, 1});
  world_.SetVelocity(other, {1, 0, 1});

  world_.Halt(box);

  ExpectTwist(world_.GetVelocity(box), {}, 0.0);
  ExpectTwist(world_.GetVelocity(other), {1, 0, 1}, 1e-6);
}

TEST_F(WorldTest, HaltStopsABodysDrives) {
  const World::Body box = AddBox(world_, {0, 0, 0});
  const World::Body other = AddBox(world_, {0, 5, 0});
  BodyDrive& drive = world_.Get(world_.AddDrive(box, {1, 1, 0}, {}));
  drive.Command({1, 0, 1});
  StepTimes(world_, 100);

  world_.Halt(other);
  EXPECT_NEAR(drive.velocity().vx, 0.5, 1e-9);
  world_.Halt(box);
  const Pose halted = world_.GetPose(box);
  StepTimes(world_, 100);

  EXPECT_EQ(drive.velocity().vx, 0.0);
  ExpectPose(world_.GetPose(box), halted, 0.0);
}

TEST_F(WorldTest, SetPoseKeepsTheVelocity) {
  const World::Body box = AddBox(world_, {0, 0, 0});
  world_.SetVelocity(box, {1, 0.5, 0.3});

  world_.SetPose(box, {-3, 4, 2});

  ExpectPose(world_.GetPose(box), {-3, 4, 2}, 1e-6);
  ExpectTwist(world_.GetVelocity(box), {1, 0.5, 0.3}, 1e-6);
  StepTimes(world_, 200);
  ExpectPose(world_.GetPose(box), {-2, 4.5, 2.3}, 1e-4);
}

TEST_F(WorldTest, SetPoseKeepsTheVelocityOfABodyThatTurnsOffItsCentre) {
  const World::Body body = world_.AddBody({});
  world_.AddCircle(body, {0.3, 0}, 0.2, Solid());
  world_.SetVelocity(body, {1, 0, 2});

  world_.SetPose(body, {0, 0, M_PI / 2});

  ExpectTwist(world_.GetVelocity(body), {1, 0, 2}, 1e-6);
}

TEST_F(WorldTest, SetPoseWakesASleepingBody) {
  const World::Body box = AddBox(world_, {0, 0, 0});
  world_.AddLayer({{{0, 2}, {4, 2}}}, 0xFFFF);
  StepTimes(world_, 400);

  // Half a metre deep in a wall: only what is awake is pushed out of it.
  world_.SetPose(box, {2, 1.6, 0});
  StepTimes(world_, 400);

  EXPECT_LT(world_.GetPose(box).y, 1.52);
}

TEST_F(WorldTest, SetPoseKeepsAHingeWithinItsLimitsAtAnyHeading) {
  const World::Body base = AddBox(world_, {0, 0, 3.0});
  const World::Body arm = AddBox(world_, {0, 0, 3.0});
  RevoluteSettings settings;
  settings.limits = {{-0.5, 0.5}};
  world_.AddRevolute(base, arm, settings);

  // The same two headings, said differently.
  world_.SetPose(base, {0, 0, 3.0 + 2.0 * M_PI});
  world_.SetPose(arm, {0, 0, 3.0 - 4.0 * M_PI});
  StepTimes(world_, 100);

  ExpectPose(world_.GetPose(base), {0, 0, 3.0}, 1e-5);
  ExpectPose(world_.GetPose(arm), {0, 0, 3.0}, 1e-5);
}

TEST_F(WorldTest, VelocityIsThatOfTheOrigin) {
  const World::Body body = world_.AddBody(At({1, 1, M_PI / 2}));
  world_.AddCircle(body, {0.3, 0}, 0.2, Solid());

  world_.SetVelocity(body, {1, 0, 2});

  ExpectTwist(world_.GetVelocity(body), {1, 0, 2}, 1e-6);
  ExpectTwist(world_.GetLocalVelocity(body), {0, -1, 2}, 1e-6);
}

TEST_F(WorldTest, ForceSpeedsUpAMass) {
  const World::Body box = AddBox(world_, {0, 0, 0}, 2.0);
  EXPECT_NEAR(world_.GetMass(box), 4.0, 1e-5);

  world_.ApplyForce(box, {8, -4});
  world_.Step(0.01);

  ExpectTwist(world_.GetVelocity(box), {0.02, -0.01, 0}, 1e-6);
}

// A body whose centre of mass is at (0.3, 0.1) of its frame: 2 m by 1 m, 2 kg/m^2, so 4 kg.
World::Body AddPlank(World& world, const Pose& pose) {
  FixtureSettings wood = Solid();
  wood.density = 2.0;
  const World::Body plank = world.AddBody(At(pose));
  world.AddPolygon(plank, {{-0.7, -0.4}, {1.3, -0.4}, {1.3, 0.6}, {-0.7, 0.6}}, wood);
  return plank;
}

constexpr double kPlankInertia = 4.0 * (2.0 * 2.0 + 1.0 * 1.0) / 12.0;  // m (a^2 + b^2) / 12

void ExpectPoint(Vec2 point, Vec2 expected, double tolerance) {
  EXPECT_NEAR(point.x, expected.x, tolerance);
  EXPECT_NEAR(point.y, expected.y, tolerance);
}

TEST_F(WorldTest, MassAndInertiaAreAboutTheCentreOfMass) {
  const World::Body plank = AddPlank(world_, {5, 6, M_PI / 2});

  EXPECT_NEAR(world_.GetMass(plank), 4.0, 1e-5);
  EXPECT_NEAR(world_.GetInertia(plank), kPlankInertia, 1e-5);
  ExpectPoint(world_.GetCenter(plank), {5 - 0.1, 6 + 0.3}, 1e-5);
}

TEST_F(WorldTest, WhatIsNotDynamicHasNoMass) {
  for (const b2BodyType type : {b2_staticBody, b2_kinematicBody}) {
    const World::Body body = world_.AddBody(At({1, 2, 0}, type));
    world_.AddCircle(body, {0.3, 0}, 1.0, Solid());

    EXPECT_EQ(world_.GetType(body), type);
    EXPECT_EQ(world_.GetMass(body), 0.0);
    EXPECT_EQ(world_.GetInertia(body), 0.0);
  }
}

TEST_F(WorldTest, ForceAtTheCentreDoesNotTurn) {
  const World::Body plank = AddPlank(world_, {5, 6, 0.4});

  world_.ApplyForce(plank, {8, -4});
  world_.Step(0.01);

  EXPECT_EQ(world_.GetVelocity(plank).omega, 0.0);
  ExpectPoint(world_.GetVelocityAt(plank, world_.GetCenter(plank)), {0.02, -0.01}, 1e-6);
}

TEST_F(WorldTest, ForceAtAPointTurnsByItsArm) {
  const World::Body plank = AddPlank(world_, {5, 6, 0.4});
  const Vec2 center = world_.GetCenter(plank), point{7, 5.5}, force{8, -4};

  world_.ApplyForce(plank, force, point);
  world_.Step(0.01);

  const double torque = Cross(point - center, force);
  EXPECT_NEAR(world_.GetVelocity(plank).omega, 0.01 * torque / kPlankInertia, 1e-6);
  ExpectPoint(world_.GetVelocityAt(plank, world_.GetCenter(plank)), {0.02, -0.01}, 1e-6);
}

TEST_F(WorldTest, TorqueTurnsAboutTheCentre) {
  const World::Body plank = AddPlank(world_, {5, 6, 0.4});

  world_.ApplyTorque(plank, -3.0);
  world_.Step(0.01);

  EXPECT_NEAR(world_.GetVelocity(plank).omega, -0.01 * 3.0 / kPlankInertia, 1e-6);
  ExpectPoint(world_.GetVelocityAt(plank, world_.GetCenter(plank)), {0, 0}, 1e-6);
}

TEST_F(WorldTest, ForcesLastForOneStep) {
  const World::Body plank = AddPlank(world_, {5, 6, 0.4});
  world_.ApplyForce(plank, {4, 0});
  world_.ApplyForce(plank, {4, -4});
  world_.ApplyTorque(plank, 1.0);

  StepTimes(world_, 10);

  const Twist velocity = world_.GetVelocity(plank);
  EXPECT_NEAR(velocity.omega, kStep / kPlankInertia, 1e-6);
  ExpectPoint(world_.GetVelocityAt(plank, world_.GetCenter(plank)), {kStep * 8 / 4, -kStep * 4 / 4},
              1e-6);
}

TEST_F(WorldTest, ImpulsesCountAtOnce) {
  const World::Body plank = AddPlank(world_, {5, 6, 0.4});
  const Vec2 center = world_.GetCenter(plank), point{4, 7}, impulse{1, -2};

  world_.ApplyLinearImpulse(plank, impulse);
  ExpectPoint(world_.GetVelocityAt(plank, center), {0.25, -0.5}, 1e-6);
  EXPECT_EQ(world_.GetVelocity(plank).omega, 0.0);

  world_.ApplyLinearImpulse(plank, impulse, point);
  const double turn = Cross(point - center, impulse) / kPlankInertia;
  ExpectPoint(world_.GetVelocityAt(plank, center), {0.5, -1.0}, 1e-6);
  EXPECT_NEAR(world_.GetVelocity(plank).omega, turn, 1e-6);

  world_.ApplyAngularImpulse(plank, 0.7);
  ExpectPoint(world_.GetVelocityAt(plank, center), {0.5, -1.0}, 1e-6);
  EXPECT_NEAR(world_.GetVelocity(plank).omega, turn + 0.7 / kPlankInertia, 1e-6);
}

TEST_F(WorldTest, VelocityAtAPointIsThatOfTheTurnToo) {
  const World::Body plank = AddPlank(world_, {5, 6, 0.4});
  world_.SetVelocity(plank, {1, 2, 3});

  ExpectPoint(world_.GetVelocityAt(plank, {5, 6}), {1, 2}, 1e-5);
  ExpectPoint(world_.GetVelocityAt(plank, {7, 5}), {1 - 3 * -1.0, 2 + 3 * 2.0}, 1e-5);
}

TEST_F(WorldTest, PushesWakeABody) {
  const std::pair<const char*, std::function<void(World::Body)>> pushes[] = {
      {"force",
       [&](World::Body body) {
         world_.ApplyForce(body, {1, 0});
       }},
      {"force at a point",
       [&](World::Body body) {
         world_.ApplyForce(body, {1, 0}, Vec2{0, 0});
       }},
      {"torque", [&](World::Body body) { world_.ApplyTorque(body, 1); }},
      {"impulse",
       [&](World::Body body) {
         world_.ApplyLinearImpulse(body, {1, 0});
       }},
      {"turning impulse", [&](World::Body body) { world_.ApplyAngularImpulse(body, 1); }},
      {"velocity",
       [&](World::Body body) {
         world_.SetVelocity(body, {1, 0, 0});
       }},
  };
  for (const auto& [name, push] : pushes) {
    const World::Body box = AddBox(world_, {0, 0, 0});
    StepTimes(world_, 200);
    ASSERT_FALSE(world_.IsAwake(box)) << name;

    push(box);

    EXPECT_TRUE(world_.IsAwake(box)) << name;
    world_.Step(kStep);
    const Twist velocity = world_.GetVelocity(box);
    EXPECT_GT(velocity.vx + velocity.omega, 0.0) << name;
    world_.RemoveBody(box);
  }
}

TEST_F(WorldTest, TurnsPointsAndVectorsFromTheBodysFrameToTheWorldsAndBack) {
  const World::Body plank = AddPlank(world_, {5, 6, M_PI / 2});

  ExpectPoint(world_.ToWorldPoint(plank, {2, 1}), {4, 8}, 1e-6);
  ExpectPoint(world_.ToLocalPoint(plank, {4, 8}), {2, 1}, 1e-6);
  ExpectPoint(world_.ToWorldVector(plank, {2, 1}), {-1, 2}, 1e-6);
  ExpectPoint(world_.ToLocalVector(plank, {-1, 2}), {2, 1}, 1e-6);
  ExpectPoint(world_.ToWorldPoint(plank, {0.3, 0.1}), world_.GetCenter(plank), 1e-5);
}

TEST_F(WorldTest, KnowsTheSettingsOfAFixture) {
  FixtureSettings settings;
  settings.density = 2.5;
  settings.friction = 0.75;
  settings.restitution = 0.5;
  settings.sensor = true;
  settings.collides = false;
  settings.visible = false;
  settings.layers = 0b1010;
  const World::Body body = world_.AddBody({});
  const Fixture plain = world_.AddCircle(body, {0, 0}, 1.0, {});
  const Fixture special = world_.AddPolygon(body, Square(1), settings);

  const FixtureSettings of_plain = world_.GetSettings(plain);
  const FixtureSettings of_special = world_.GetSettings(special);

  EXPECT_EQ(world_.GetFixtureCount(body), 2);
  EXPECT_EQ(of_special.density, 2.5);
  EXPECT_EQ(of_special.friction, 0.75);
  EXPECT_EQ(of_special.restitution, 0.5);
  EXPECT_TRUE(of_special.sensor);
  EXPECT_FALSE(of_special.collides);
  EXPECT_FALSE(of_special.visible);
  EXPECT_EQ(of_special.layers, 0b1010);
  EXPECT_EQ(of_plain.density, 0.0);
  EXPECT_FALSE(of_plain.sensor);
  EXPECT_TRUE(of_plain.collides);
  EXPECT_TRUE(of_plain.visible);
  EXPECT_EQ(of_plain.layers, 0xFFFF);
}

TEST_F(WorldTest, ChangesFrictionAndRestitutionOfAFixture) {
  world_.AddLayer({{{2, -5}, {2, 5}}}, 0xFFFF);
  const World::Body box = AddBox(world_, {0, 0, 0});

  world_.SetRestitution({box, 0}, 0.5);
  world_.SetFriction({box, 0}, 0.25);

  EXPECT_EQ(world_.GetSettings({box, 0}).restitution, 0.5);
  EXPECT_EQ(world_.GetSettings({box, 0}).friction, 0.25);
  world_.SetVelocity(box, {4, 0, 0});
  StepTimes(world_, 200);
  EXPECT_NEAR(world_.GetVelocity(box).vx, -2.0, 1e-3);
}

TEST_F(WorldTest, FrictionThatIsSetSlowsABoxDown) {
  world_.AddLayer({{{-50, 0}, {50, 0}}}, 0xFFFF);
  const World::Body box = AddBox(world_, {0, 0.51, 0});
  world_.SetFriction({box, 0}, 1.0);
  world_.SetVelocity(box, {2, 0, 0});

  for (int step = 0; step < 200; ++step) {
    world_.ApplyForce(box, {0, -1});
    world_.Step(kStep);
  }

  EXPECT_LT(world_.GetVelocity(box).vx, 1.8);
}

TEST_F(WorldTest, KnowsWhetherAPointIsWithinAFixture) {
  const World::Body body = world_.AddBody(At({5, 6, M_PI / 2}));
  const Fixture circle = world_.AddCircle(body, {2, 0}, 0.5, Solid());
  const Fixture square = world_.AddPolygon(body, Square(1), Solid());

  EXPECT_TRUE(world_.TestPoint(circle, {5, 8.4}));
  EXPECT_FALSE(world_.TestPoint(circle, {5, 8.6}));
  EXPECT_FALSE(world_.TestPoint(circle, {5.4, 6.4}));
  EXPECT_TRUE(world_.TestPoint(square, {5.4, 6.4}));
  EXPECT_FALSE(world_.TestPoint(square, {7, 6}));
}

TEST_F(WorldTest, ALayerIsABodyOfWalls) {
  const World::Body layer = world_.AddLayer({{{0, 0}, {4, 0}}, {{4, 0}, {4, 3}}}, 0b101);

  EXPECT_TRUE(world_.Contains(layer));
  EXPECT_EQ(world_.GetType(layer), b2_staticBody);
  EXPECT_EQ(world_.GetFixtureCount(layer), 2);
  EXPECT_EQ(world_.GetSettings({layer, 1}).layers, 0b101);
  EXPECT_FALSE(world_.TestPoint({layer, 1}, {4, 1}));  // a wall is not thick
  ExpectPose(world_.GetPose(layer), {}, 0.0);
  EXPECT_EQ(world_.GetMass(layer), 0.0);
  EXPECT_THROW(world_.GetSettings({layer, 2}), std::invalid_argument);
}

TEST_F(WorldTest, ALayerStaysForGoodWhereItIs) {
  const World::Body layer = world_.AddLayer({{{2, -5}, {2, 5}}}, 0xFFFF);

  EXPECT_THROW(world_.RemoveBody(layer), std::invalid_argument);
  EXPECT_THROW(world_.SetPose(layer, {1, 0, 0}), std::invalid_argument);
  EXPECT_THROW(world_.AddCircle(layer, {0, 0}, 1.0, Solid()), std::invalid_argument);
  EXPECT_THROW(world_.AddPolygon(layer, Square(1), Solid()), std::invalid_argument);

  // Nor do pushes move it; and it stops what it did.
  world_.SetVelocity(layer, {1, 0, 0});
  world_.ApplyForce(layer, {5, 0});
  world_.ApplyLinearImpulse(layer, {5, 0});
  const World::Body box = AddBox(world_, {0, 0, 0});
  world_.SetVelocity(box, {2, 0, 0});
  StepTimes(world_, 400);
  ExpectPose(world_.GetPose(layer), {}, 0.0);
  EXPECT_EQ(world_.GetFixtureCount(layer), 1);
  EXPECT_LT(world_.GetPose(box).x, 1.6);
}

TEST_F(WorldTest, WhatIsNotVisibleCollidesButIsNotSeen) {
  FixtureSettings glass = Solid();
  glass.visible = false;
  const World::Body box = AddBox(world_, {3, 0, 0}, 1.0, glass);
  AddBox(world_, {6, 0, 0});
  ScanSettings lidar;
  lidar.range = 20.0;
  const auto look = [&] {
    float range = -1.0f, intensity = -1.0f;
    world_.Scan(BeamFan(0, 0, 1), {}, lidar, &range, &intensity);
    return range;
  };

  EXPECT_NEAR(look(), 5.5, 1e-4);

  // Of the fixtures of a body, each for itself.
  world_.AddCircle(box, {0, 0}, 0.2, Solid());
  EXPECT_NEAR(look(), 2.8, 1e-4);

  const World::Body thrown = AddBox(world_, {3, 3, 0});
  world_.SetVelocity(thrown, {0, -2, 0});
  StepTimes(world_, 400);
  EXPECT_GT(world_.GetPose(thrown).y, world_.GetPose(box).y + 0.9);
}

TEST_F(WorldTest, BouncesBackAtItsRestitution) {
  world_.AddLayer({{{2, -5}, {2, 5}}}, 0xFFFF);
  FixtureSettings rubber = Solid();
  rubber.restitution = 0.5;
  const World::Body box = AddBox(world_, {0, 0, 0}, 1.0, rubber);
  world_.SetVelocity(box, {4, 0, 0});

  StepTimes(world_, 200);

  ExpectTwist(world_.GetVelocity(box), {-2, 0, 0}, 1e-3);
}

TEST_F(WorldTest, FrictionSlowsABoxThatSlidesAlongAWall) {
  for (const double friction : {0.0, 1.0}) {
    World world(10, 10);
    world.AddLayer({{{-50, 0}, {50, 0}}}, 0xFFFF);
    FixtureSettings settings = Solid();
    settings.friction = friction;
    const World::Body box = AddBox(world, {0, 0.51, 0}, 1.0, settings);
    world.SetVelocity(box, {2, 0, 0});

    for (int step = 0; step < 200; ++step) {
      world.ApplyForce(box, {0, -1});
      world.Step(kStep);
    }

    if (friction == 0.0) {
      EXPECT_NEAR(world.GetVelocity(box).vx, 2.0, 1e-4);
    } else {
      EXPECT_LT(world.GetVelocity(box).vx, 1.8);
    }
  }
}

TEST_F(WorldTest, DampingSlowsDown) {
  BodySettings settings;
  settings.linear_damping = 2.0;
  settings.angular_damping = 1.0;
  const World::Body body = world_.AddBody(settings);
  world_.AddPolygon(body, Square(1), Solid());
  world_.SetVelocity(body, {1, 0, 1});

  StepTimes(world_, 100);

  ExpectTwist(world_.GetVelocity(body), {std::exp(-1.0), 0, std::exp(-0.5)}, 0.005);
}

struct Refusal {
  const char* name;
  std::function<void(World&, World::Body box, World::Body other)> attempt;
};

void PrintTo(const Refusal& refusal, std::ostream* out) { *out << refusal.name; }

class Refused : public testing::TestWithParam<Refusal> {};

TEST_P(Refused, LeavesTheWorldAsItWas) {
  World world(10, 10);
  const World::Body box = AddBox(world, {0, 0, 0});
  const World::Body other = AddBox(world, {3, 0, 0});
  world.SetVelocity(box, {1, 0, 0});

  ASSERT_THROW(GetParam().attempt(world, box, other), std::invalid_argument);

  EXPECT_EQ(world.body_count(), 2);
  EXPECT_EQ(world.joint_count(), 0);
  EXPECT_NEAR(world.GetMass(box), 1.0, 1e-6);
  StepTimes(world, 200);
  ExpectPose(world.GetPose(box), {1, 0, 0}, 1e-4);
}

// One refusal for each thing said here.
Refusal PoseOf(const char* name, const Pose& pose) {
  return {name, [pose](World& w, World::Body, World::Body) { w.AddBody(At(pose)); }};
}
Refusal PutAt(const char* name, const Pose& pose) {
  return {name, [pose](World& w, World::Body box, World::Body) { w.SetPose(box, pose); }};
}
Refusal Moving(const char* name, const Twist& twist) {
  return {name, [twist](World& w, World::Body box, World::Body) { w.SetVelocity(box, twist); }};
}
Refusal Pushed(const char* name, Vec2 force, double torque) {
  return {name, [=](World& w, World::Body box, World::Body) {
            w.ApplyForce(box, force);
            w.ApplyTorque(box, torque);
          }};
}
Refusal PushedAt(const char* name, Vec2 point) {
  return {name, [=](World& w, World::Body box, World::Body) {
            EXPECT_THROW(w.ApplyLinearImpulse(box, {1, 0}, point), std::invalid_argument);
            EXPECT_THROW(w.GetVelocityAt(box, point), std::invalid_argument);
            EXPECT_THROW(w.TestPoint({box, 0}, point), std::invalid_argument);
            w.ApplyForce(box, {1, 0}, point);
          }};
}
Refusal Struck(const char* name, Vec2 impulse, double angular) {
  return {name, [=](World& w, World::Body box, World::Body) {
            w.ApplyLinearImpulse(box, impulse);
            w.ApplyAngularImpulse(box, angular);
          }};
}
Refusal Rubbed(const char* name, double value) {
  return {name, [=](World& w, World::Body box, World::Body) {
            EXPECT_THROW(w.SetFriction({box, 0}, value), std::invalid_argument);
            w.SetRestitution({box, 0}, value);
          }};
}
Refusal Driven(const char* name, const Twist& twist) {
  return {name, [twist](World& w, World::Body, World::Body other) {
            w.Get(w.AddDrive(other, {}, {})).Command(twist);
          }};
}
Refusal Damped(const char* name, double linear, double angular) {
  return {name, [=](World& w, World::Body, World::Body) {
            BodySettings settings;
            settings.linear_damping = linear;
            settings.angular_damping = angular;
            w.AddBody(settings);
          }};
}
Refusal Circle(const char* name, Vec2 center, double radius) {
  return {name, [=](World& w, World::Body box, World::Body) {
            w.AddCircle(box, center, radius, Solid());
          }};
}
Refusal Polygon(const char* name, const std::vector<Vec2>& vertices) {
  return {name,
          [=](World& w, World::Body box, World::Body) { w.AddPolygon(box, vertices, Solid()); }};
}
Refusal Material(const char* name, double density, double friction, double restitution) {
  return {name, [=](World& w, World::Body box, World::Body) {
            FixtureSettings settings;
            settings.density = density;
            settings.friction = friction;
            settings.restitution = restitution;
            w.AddPolygon(box, Square(1), settings);
          }};
}
Refusal Wall(const char* name, const Segment& wall) {
  return {name, [wall](World& w, World::Body, World::Body) {
            w.AddLayer({{{5, 5}, {6, 6}}, wall}, 0xFFFF);
          }};
}
Refusal Limits(const char* name, double lower, double upper) {
  return {name, [=](World& w, World::Body box, World::Body other) {
            RevoluteSettings settings;
            settings.limits = {{lower, upper}};
            w.AddRevolute(box, other, settings);
          }};
}
Refusal Anchors(const char* name, Vec2 a, Vec2 b) {
  return {name, [=](World& w, World::Body box, World::Body other) {
            RevoluteSettings revolute;
            revolute.anchor_a = a;
            revolute.anchor_b = b;
            EXPECT_THROW(w.AddRevolute(box, other, revolute), std::invalid_argument);
            WeldSettings weld;
            weld.anchor_a = a;
            weld.anchor_b = b;
            w.AddWeld(box, other, weld);
          }};
}
Refusal Weld(const char* name, double angle, double frequency, double damping) {
  return {name, [=](World& w, World::Body box, World::Body other) {
            WeldSettings settings;
            settings.angle = angle;
            settings.frequency = frequency;
            settings.damping = damping;
            w.AddWeld(box, other, settings);
          }};
}
Refusal Stepping(const char* name, double dt) {
  return {name, [dt](World& w, World::Body, World::Body) { w.Step(dt); }};
}

std::string NameOf(const testing::TestParamInfo<Refusal>& info) { return info.param.name; }

INSTANTIATE_TEST_SUITE_P(
    Bodies, Refused,
    testing::Values(
        PoseOf("body_at_nan", {kNaN, 0, 0}), PoseOf("body_at_inf", {0, kInfinity, 0}),
        PoseOf("body_beyond_100_km", {0, -1.1e5, 0}), PoseOf("body_towards_nan", {0, 0, kNaN}),
        PoseOf("body_towards_inf", {0, 0, kInfinity}), PutAt("put_at_nan", {kNaN, 0, 0}),
        PutAt("put_at_inf", {0, -kInfinity, 0}), PutAt("put_beyond_100_km", {1.1e5, 0, 0}),
        PutAt("put_towards_nan", {0, 0, kNaN}), Moving("moving_at_nan", {kNaN, 0, 0}),
        Moving("moving_at_inf", {0, kInfinity, 0}), Moving("turning_at_nan", {0, 0, kNaN}),
        Pushed("pushed_by_nan", {kNaN, 0}, 0), Pushed("pushed_by_inf", {0, kInfinity}, 0),
        Pushed("torque_of_nan", {0, 0}, kNaN), PushedAt("pushed_at_nan", {kNaN, 0}),
        PushedAt("pushed_at_inf", {0, kInfinity}), Struck("struck_by_nan", {0, kNaN}, 0),
        Struck("struck_by_inf", {kInfinity, 0}, 0), Struck("turned_by_nan", {0, 0}, kNaN),
        Driven("driven_at_nan", {kNaN, 0, 0}), Damped("negative_linear_damping", -1, 0),
        Damped("negative_angular_damping", 0, -1), Damped("damping_of_nan", kNaN, 0),
        Damped("angular_damping_of_inf", 0, kInfinity)),
    NameOf);

INSTANTIATE_TEST_SUITE_P(
    Fixtures, Refused,
    testing::Values(
        Circle("circle_of_no_radius", {0, 0}, 0), Circle("circle_of_negative_radius", {0, 0}, -1),
        Circle("circle_of_nan_radius", {0, 0}, kNaN),
        Circle("circle_of_inf_radius", {0, 0}, kInfinity), Circle("circle_at_nan", {kNaN, 0}, 1),
        Circle("circle_at_inf", {0, kInfinity}, 1), Polygon("polygon_of_no_vertices", {}),
        Polygon("polygon_of_two_vertices", {{0, 0}, {1, 0}}),
        Polygon("polygon_of_nine_vertices", {{1, 0},
                                             {.8, .6},
                                             {0, 1},
                                             {-.6, .8},
                                             {-1, 0},
                                             {-.8, -.6},
                                             {0, -1},
                                             {.6, -.8},
                                             {.9, -.3}}),
        Polygon("polygon_with_a_nan", {{0, 0}, {1, 0}, {1, kNaN}}),
        Polygon("polygon_with_an_inf", {{0, 0}, {1, 0}, {kInfinity, 1}}),
        Polygon("polygon_on_a_line", {{0, 0}, {1, 1}, {2, 2}, {3, 3}}),
        Polygon("polygon_of_one_point", {{1, 1}, {1, 1}, {1, 1}}),
        Polygon("polygon_of_welded_vertices", {{0, 0}, {0.002, 0}, {0, 0.002}}),
        Polygon("polygon_of_two_pairs", {{0, 0}, {0, 0.002}, {1, 0}, {1, 0.002}}),
        Material("negative_density", -1, 0, 0), Material("negative_friction", 0, -1, 0),
        Material("negative_restitution", 0, 0, -1), Material("density_of_nan", kNaN, 0, 0),
        Material("friction_of_inf", 0, kInfinity, 0), Material("restitution_of_nan", 0, 0, kNaN),
        Rubbed("set_to_negative", -0.1), Rubbed("set_to_nan", kNaN),
        Rubbed("set_to_inf", kInfinity),
        Refusal{"fixture_that_is_not_there",
                [](World& w, World::Body box, World::Body) {
                  w.GetSettings({box, 1});
                }},
        Wall("wall_of_no_length", {{1, 2}, {1, 2}}), Wall("wall_from_nan", {{kNaN, 2}, {1, 2}}),
        Wall("wall_to_inf", {{1, 2}, {kInfinity, 2}})),
    NameOf);

INSTANTIATE_TEST_SUITE_P(
    Joints, Refused,
    testing::Values(Limits("limits_in_the_wrong_order", 0.5, -0.5), Limits("limit_of_nan", kNaN, 1),
                    Limits("limit_of_inf", 0, kInfinity),
                    Anchors("anchor_at_nan", {kNaN, 0}, {0, 0}),
                    Anchors("anchor_at_inf", {0, 0}, {0, kInfinity}),
                    Weld("weld_angle_of_nan", kNaN, 0, 0), Weld("negative_frequency", 0, -1, 0),
                    Weld("frequency_of_inf", 0, kInfinity, 0), Weld("negative_ratio", 0, 1, -1),
                    Weld("ratio_of_nan", 0, 1, kNaN),
                    Refusal{"hinge_with_itself", [](World& w, World::Body box,
                                                    World::Body) { w.AddRevolute(box, box, {}); }},
                    Refusal{"weld_with_itself", [](World& w, World::Body box,
                                                   World::Body) { w.AddWeld(box, box, {}); }},
                    Refusal{"negative_drive_limit",
                            [](World& w, World::Body box, World::Body) {
                              w.AddDrive(box, {-1, 0, 0}, {});
                            }}),
    NameOf);

INSTANTIATE_TEST_SUITE_P(Steps, Refused,
                         testing::Values(Stepping("step_of_zero", 0), Stepping("step_back", -0.01),
                                         Stepping("step_of_nan", kNaN),
                                         Stepping("step_of_inf", kInfinity)),
                         NameOf);

// What double precision holds and single precision, in Box2D, does not.
INSTANTIATE_TEST_SUITE_P(
    SinglePrecision, Refused,
    testing::Values(
        Moving("moving_too_fast", {kTooMuch, 0, 0}), Moving("turning_too_fast", {0, 0, kTooMuch}),
        Pushed("pushed_too_hard", {0, kTooMuch}, 0), Struck("struck_too_hard", {0, kTooMuch}, 0),
        Struck("turned_too_hard", {0, 0}, kTooMuch), PushedAt("pushed_too_far_off", {kTooMuch, 0}),
        Pushed("too_much_torque", {0, 0}, kTooMuch), Driven("driven_too_fast", {kTooMuch, 0, 0}),
        Material("too_much_density", kTooMuch, 0, 0), Material("too_much_friction", 0, kTooMuch, 0),
        Material("too_much_restitution", 0, 0, kTooMuch),
        Weld("weld_angle_too_large", kTooMuch, 0, 0), Weld("weld_too_stiff", 0, kTooMuch, 0),
        Stepping("step_too_short", 1e-40), Stepping("step_too_long", kTooMuch),
        Damped("too_much_damping", kTooMuch, 0),
        Polygon("far_polygon_of_one_point",
                {{99999, 99999}, {99999.003, 99999}, {99999, 99999.003}}),
        Polygon("sliver_of_a_polygon", {{-1.20094163, -0.88022375},
                                        {-3.49046546, -2.10999363},
                                        {-1.6374956, -1.11470961},
                                        {-3.61502771, -2.17689854}}),
        Circle("circle_of_hardly_any_radius", {0, 0}, 1e-10),
        Polygon("far_polygon_on_a_line", {{1000, 1000}, {1001, 1001}, {1002, 1002.00001}})),
    NameOf);

// Such a circle's moment of inertia is lost in rounding. It is refused for what it does to the
// mass, so without density it is welcome.
TEST_F(WorldTest, RefusesATinyCircleFarFromItsBodysOrigin) {
  const World::Body body = world_.AddBody({});

  EXPECT_THROW(world_.AddCircle(body, {1000, 0}, 0.001, Solid()), std::invalid_argument);
  EXPECT_NO_THROW(world_.AddCircle(body, {1000, 0}, 0.001, {}));

  EXPECT_EQ(world_.body_count(), 1);
  world_.SetVelocity(body, {1, 0, 0});
  StepTimes(world_, 200);
  EXPECT_NEAR(world_.GetPose(body).x, 1.0, 1e-4);
}

TEST_F(WorldTest, RefusesASolverWithoutIterations) {
  EXPECT_THROW(World(0, 10), std::invalid_argument);
  EXPECT_THROW(World(10, 0), std::invalid_argument);
}

TEST_F(WorldTest, TakesTheConvexHullOfAPolygon) {
  const World::Body body = world_.AddBody({});

  world_.AddPolygon(body, {{0, 0}, {2, 0}, {1, 0.2}, {2, 2}, {0, 2}}, Solid());

  EXPECT_NEAR(world_.GetMass(body), 4.0, 1e-5);
}

// In single precision an angle of 3000 rad would be wrong by a step's hundredth part.
constexpr int kLongSpin = 200000;
constexpr double kSpin = 3.0;

TEST_F(WorldTest, SpinsOnForAVeryLongTime) {
  const World::Body body = AddBox(world_, {1, 2, 0});
  world_.SetVelocity(body, {0, 0, kSpin});

  for (int step = 0; step < kLongSpin; ++step) {
    const double before = world_.GetPose(body).yaw;
    world_.Step(kStep);
    ASSERT_NEAR(Turn(before, world_.GetPose(body).yaw), kSpin * kStep, 2e-6) << "step " << step;
  }
}

TEST_F(WorldTest, SpinsOnWithAWeldedCompanionForAVeryLongTime) {
  const World::Body body = AddBox(world_, {0, 0, 0}, 0.4);
  const World::Body companion = AddBox(world_, {0.5, 0, 0.3}, 0.1);
  WeldSettings settings;
  settings.anchor_a = {0.5, 0};
  settings.angle = 0.3;
  const World::Joint weld = world_.AddWeld(body, companion, settings);
  world_.Get(world_.AddDrive(body, {}, {})).Command({0, 0, kSpin});
  StepTimes(world_, 1000);

  for (int step = 0; step < kLongSpin; ++step) {
    const double before = world_.GetPose(body).yaw;
    world_.Step(kStep);
    const Pose pose = world_.GetPose(body), other = world_.GetPose(companion);
    ASSERT_NEAR(Turn(before, pose.yaw), kSpin * kStep, 2e-5) << "step " << step;
    ASSERT_LT(std::abs(world_.JointAngle(weld)), 0.01) << "step " << step;
    ASSERT_NEAR(std::hypot(other.x - pose.x, other.y - pose.y), 0.5, 0.005) << "step " << step;
  }
}

TEST_F(WorldTest, SpinsOnUponAHingeForAVeryLongTime) {
  const World::Body post = AddPost(world_, {0, 0, 0});
  const World::Body wheel = AddBox(world_, {0, 0, 0}, 0.2);
  world_.AddRevolute(post, wheel, {});
  world_.SetVelocity(wheel, {0, 0, kSpin});

  for (int step = 0; step < kLongSpin; ++step) {
    const double before = world_.GetPose(wheel).yaw;
    world_.Step(kStep);
    ASSERT_NEAR(Turn(before, world_.GetPose(wheel).yaw), kSpin * kStep, 2e-6) << "step " << step;
  }
}

TEST_F(WorldTest, SpinsOnWithAHingedArmWithinItsLimits) {
  const World::Body base = AddBox(world_, {0, 0, 0}, 0.4);
  const World::Body arm = AddBox(world_, {0, 0, 0.1}, 0.1);
  RevoluteSettings settings;
  settings.limits = {{-0.2, 0.2}};
  const World::Joint hinge = world_.AddRevolute(base, arm, settings);
  world_.SetVelocity(base, {0, 0, kSpin});
  world_.SetVelocity(arm, {0, 0, kSpin});

  for (int step = 0; step < 20000; ++step) {
    world_.Step(kStep);
    ASSERT_NEAR(world_.JointAngle(hinge), 0.1, 0.001) << "step " << step;
  }
}

std::vector<Pose> PlayOut() {
  World world(10, 10);
  world.AddLayer({{{-5, -5}, {5, -5}}, {{5, -5}, {5, 5}}, {{5, 5}, {-5, 5}}, {{-5, 5}, {-5, -5}}},
                 0xFFFF);
  std::vector<World::Body> bodies;
  for (int i = 0; i < 16; ++i) {
    const World::Body body = AddBox(world, {-3.0 + 2 * (i % 4), -3.0 + 2 * (i / 4), 0.3 * i}, 0.8);
    world.SetVelocity(body, {2.0 * std::cos(i), 2.0 * std::sin(i), 0.1 * i});
    bodies.push_back(body);
  }
  RevoluteSettings hinge;
  hinge.anchor_a = {1, 0};
  hinge.anchor_b = {-1, 0};
  world.AddRevolute(bodies[0], bodies[1], hinge);
  world.Get(world.AddDrive(bodies[5], {1, 1, 1}, {})).Command({1, 0, 0.5});
  StepTimes(world, 1000);
  std::vector<Pose> poses;
  for (World::Body body : bodies) poses.push_back(world.GetPose(body));
  return poses;
}

TEST(World, EqualWorldsGoTheSameWayToTheLastBit) {
  const std::vector<Pose> once = PlayOut();
  const std::vector<Pose> again = PlayOut();

  for (size_t i = 0; i < once.size(); ++i) {
    EXPECT_EQ(once[i].x, again[i].x) << "body " << i;
    EXPECT_EQ(once[i].y, again[i].y) << "body " << i;
    EXPECT_EQ(once[i].yaw, again[i].yaw) << "body " << i;
  }
}

}  // namespace
}  // namespace flatland
