/// Collisions of fixtures; restitution and friction.

#include <gtest/gtest.h>

#include <ostream>

#include "test_bodies.hpp"
#include "world/world.hpp"

namespace flatland {
namespace {

FixtureSettings Ghost() {
  FixtureSettings settings = Solid();
  settings.collides = false;
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

}  // namespace
}  // namespace flatland
