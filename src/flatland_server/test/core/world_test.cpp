/// Bodies: removal, moves, collisions, layers; access by one thread at a time; reproducibility.

#include "world/world.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <ostream>
#include <stdexcept>
#include <thread>
#include <vector>

#include "test_bodies.hpp"
#include "world/box2d_timer.hpp"

namespace flatland {
namespace {

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
  EXPECT_THROW(world_.GetJointAngle(hinge), GoneError);
  EXPECT_THROW(world_.GetJointAngle(weld), GoneError);
  EXPECT_THROW(world_.Get(drive_b), GoneError);
  EXPECT_THROW(world_.Get(second_drive_b), GoneError);
  EXPECT_NO_THROW(world_.GetJointAngle(other));
  EXPECT_NO_THROW(world_.Get(drive_a));
  StepTimes(world_, 10);
}

TEST_F(WorldTest, BodyInTheSlotOfARemovedOneDoesNotGetItsDrive) {
  const World::Body a = AddBox(world_, {0, 0, 0});
  const World::Body b = AddBox(world_, {2, 0, 0});
  world_.Get(world_.AddDrive(b, {}, {})).Command({1, 0, 0});
  world_.RemoveBody(b);
  const World::Body c = AddBox(world_, {4, 0, 0});

  StepTimes(world_, 100);

  ExpectPose(world_.GetPose(a), {0, 0, 0}, 0.0);
  ExpectPose(world_.GetPose(c), {4, 0, 0}, 0.0);
}

TEST_F(WorldTest, IsForOneThreadWhileGuarded) {
  const World::Body box = AddBox(world_, {0, 0, 0});
  const auto on_another_thread = [](auto act) { std::thread(act).join(); };
  {
    const World::AccessGuard guard(world_);

    on_another_thread([&] {
      EXPECT_THROW(world_.GetPose(box), std::logic_error);
      EXPECT_THROW(world_.Step(kStep), std::logic_error);
      EXPECT_THROW(World::AccessGuard{world_}, std::logic_error);
    });
    EXPECT_NO_THROW(world_.Step(kStep, guard));
    on_another_thread([&] { EXPECT_THROW(world_.AddBody({}), std::logic_error); });
  }
  on_another_thread([&] { EXPECT_NO_THROW(world_.Step(kStep)); });
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

TEST(World, EqualWorldsMoveEquallyToTheLastBit) { ExpectSame(PlayOut(), PlayOut()); }

TEST_F(WorldTest, SetPoseKeepsTheVelocity) {
  const World::Body box = AddBox(world_, {0, 0, 0});
  world_.SetVelocity(box, {1, 0.5, 0.3});

  world_.SetPose(box, {-3, 4, 2});

  ExpectPose(world_.GetPose(box), {-3, 4, 2}, 1e-6);
  ExpectTwist(world_.GetVelocity(box), {1, 0.5, 0.3}, 1e-6);
  StepTimes(world_, 200);
  ExpectPose(world_.GetPose(box), {-2, 4.5, 2.3}, 1e-4);
}

TEST_F(WorldTest, SetPoseKeepsTheVelocityOfABodyThatRotatesOffItsCentre) {
  const World::Body body = AddDisc(world_, {}, 0.2, Solid(), {0.3, 0});
  world_.SetVelocity(body, {1, 0, 2});

  world_.SetPose(body, {0, 0, M_PI / 2});

  ExpectTwist(world_.GetVelocity(body), {1, 0, 2}, 1e-6);
}

TEST_F(WorldTest, SetPoseWakesASleepingBody) {
  const World::Body box = AddBox(world_, {0, 0, 0});
  world_.AddLayer({{{0, 2}, {4, 2}}}, 0xFFFF);
  StepTimes(world_, 400);

  // Half a metre deep in a wall: Box2D pushes only awake bodies out of it.
  world_.SetPose(box, {2, 1.6, 0});
  StepTimes(world_, 400);

  EXPECT_LT(world_.GetPose(box).y, 1.52);
}

TEST_F(WorldTest, SetPoseKeepsAHingeWithinItsLimitsAtAnyHeading) {
  const World::Body base = AddBox(world_, {0, 0, 3.0});
  const World::Body arm = AddBox(world_, {0, 0, 3.0});
  world_.AddRevolute(base, arm, HingeWithin(-0.5, 0.5));

  // The same headings, whole rotations away.
  world_.SetPose(base, {0, 0, 3.0 + 2.0 * M_PI});
  world_.SetPose(arm, {0, 0, 3.0 - 4.0 * M_PI});
  StepTimes(world_, 100);

  ExpectPose(world_.GetPose(base), {0, 0, 3.0}, 1e-5);
  ExpectPose(world_.GetPose(arm), {0, 0, 3.0}, 1e-5);
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

TEST_F(WorldTest, ALayerCannotBeMovedOrRemoved) {
  const World::Body layer = world_.AddLayer({{{2, -5}, {2, 5}}}, 0xFFFF);

  EXPECT_THROW(world_.RemoveBody(layer), std::invalid_argument);
  EXPECT_THROW(world_.SetPose(layer, {1, 0, 0}), std::invalid_argument);
  EXPECT_THROW(world_.AddCircle(layer, {0, 0}, 1.0, Solid()), std::invalid_argument);
  EXPECT_THROW(world_.AddPolygon(layer, Square(1), Solid()), std::invalid_argument);

  // Forces do not move it either, and it still stops bodies.
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

// In a step the first box moves by more than its own length; the other one is driven.
TEST_F(WorldTest, FastBoxesDoNotPassThroughAWall) {
  world_.AddLayer({{{3.03, -5}, {3.03, 5}}}, 0xFFFF);
  const World::Body box = AddBox(world_, {0, 0, 0}, 0.04);
  world_.SetVelocity(box, {20, 0, 0});
  const World::Body driven = AddBox(world_, {0, 2, 0}, 0.4);
  world_.Get(world_.AddDrive(driven, {}, {})).Command({20, 0, 0});

  StepTimes(world_, 400);

  EXPECT_NEAR(world_.GetPose(box).x, 2.98, 0.05);
  EXPECT_LT(world_.GetPose(driven).x, 3.03);
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

TEST(Box2DTimerTest, Box2DDoesNotReadTheClock) { EXPECT_FALSE(Box2DReadsClock()); }

}  // namespace
}  // namespace flatland
