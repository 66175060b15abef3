/// Moving bodies by SetPose.

#include <gtest/gtest.h>

#include <cmath>

#include "test_bodies.hpp"
#include "world/world.hpp"

namespace flatland {
namespace {

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

  // Half a metre deep in a wall: Box2D pushes only awake bodies out of it.
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

  // The same headings, whole rotations away.
  world_.SetPose(base, {0, 0, 3.0 + 2.0 * M_PI});
  world_.SetPose(arm, {0, 0, 3.0 - 4.0 * M_PI});
  StepTimes(world_, 100);

  ExpectPose(world_.GetPose(base), {0, 0, 3.0}, 1e-5);
  ExpectPose(world_.GetPose(arm), {0, 0, 3.0}, 1e-5);
}

}  // namespace
}  // namespace flatland
