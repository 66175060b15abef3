/// Removal of bodies; access by one thread at a time; reproducibility.

#include "world/world.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <stdexcept>
#include <thread>
#include <vector>

#include "test_bodies.hpp"

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

TEST(World, EqualWorldsMoveEquallyToTheLastBit) {
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
