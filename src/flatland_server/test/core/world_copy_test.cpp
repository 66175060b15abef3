/// World::Copy: a world that makes the same steps.

#include <gtest/gtest.h>

#include "test_bodies.hpp"

namespace flatland {
namespace {

class WorldCopyTest : public WorldTest {
 protected:
  /// Three boxes between walls, two of them welded, one on a tween; a driven box runs into them.
  void Fill() {
    world_.AddLayer({{{-3, -3}, {3, -3}}, {{3, -3}, {3, 3}}, {{3, 3}, {-3, 3}}}, kAllLayers);
    driven_ = AddBox(world_, {-2, 0, 0.1}, 0.5);
    world_.AddCircle(driven_, {0.2, 0.1}, 0.3, Solid());
    drive_ = world_.AddDrive(driven_, {}, {});
    const World::Body other = AddBox(world_, {-2.6, 0, 0}, 0.4);
    world_.AddWeld(driven_, other, WeldAt({-0.6, 0.0}));
    arm_ = AddBox(world_, {1.6, 1.5, 0}, 0.3);
    world_.SetMass(arm_, 3.0, 0.7, Vec2{0.04, -0.03});
    RevoluteSettings hinge;
    hinge.anchor_b = {-0.6, 0.0};
    hinge_ = world_.AddRevolute(AddPost(world_, {1, 1.5, 0}), arm_, hinge);
    world_.SetLimits(hinge_, JointLimits(-0.6, 0.5));
    world_.SetMotor(hinge_, JointMotor{1.5, 0.4});
    box_ = AddBox(world_, {0, 0.2, 0.3}, 0.7);
    AddBox(world_, {0.9, 0, 0.2}, 0.6);
    const World::Body door = world_.AddBody(At({0, -1.5, 0}, b2_kinematicBody));
    world_.AddPolygon(door, Square(0.5), Solid());
    TweenSettings tween;
    tween.delta = {0, 1.2, 1};
    world_.AddTween(door, tween);
  }

  World::Body driven_;
  World::Body box_;
  World::Body arm_;
  World::Joint hinge_;
  World::Drive drive_;
};

void ExpectSame(const World& a, const World& b, World::Body body) {
  EXPECT_EQ(a.GetPose(body), b.GetPose(body));
  EXPECT_EQ(a.GetVelocity(body).vx, b.GetVelocity(body).vx);
  EXPECT_EQ(a.GetVelocity(body).omega, b.GetVelocity(body).omega);
}

TEST_F(WorldCopyTest, MakesTheSteps) {
  Fill();
  const std::unique_ptr<World> copy = world_.Copy();
  for (int step = 0; step < 600; ++step) {
    for (World* world : {&world_, copy.get()}) {
      world->Get(drive_).Command({1.5, 0.0, step % 100 < 50 ? 0.8 : -0.7});
      world->Step(kStep);
    }
    for (const World::Body body : {driven_, box_, arm_}) ExpectSame(world_, *copy, body);
  }
  EXPECT_FALSE(world_.contacts().GetTouches().empty());
  EXPECT_EQ(copy->GetMass(driven_), world_.GetMass(driven_));
  EXPECT_NEAR(world_.GetJointAngle(hinge_), 0.5, 0.04);
}

TEST_F(WorldCopyTest, IsIndependent) {
  Fill();
  const std::unique_ptr<World> copy = world_.Copy();
  copy->SetPose(box_, {1, 1, 1});
  EXPECT_EQ(world_.GetPose(box_).x, 0.0);
}

TEST_F(WorldCopyTest, GoesOnFromWhereItWas) {
  Fill();
  world_.Get(drive_).Command({1.5, 0.0, 0.3});
  StepTimes(world_, 150);
  world_.RemoveBody(box_);
  world_.SetCircle({driven_, 0}, {0.1, 0.0}, 0.4);  // the order of its fixtures is another one now
  box_ = AddBox(world_, {0.5, 0.6, 0.3}, 0.7);
  for (int round = 0; round < 20; ++round) {
    const std::unique_ptr<World> copy = world_.Copy();
    EXPECT_EQ(copy->SaveState(), world_.SaveState()) << round;
    for (int step = 0; step < 40; ++step) {
      for (World* world : {&world_, copy.get()}) {
        world->Get(drive_).Command({1.5, 0.0, step % 20 < 10 ? 0.8 : -0.7});
        world->Step(kStep);
      }
    }
    EXPECT_EQ(copy->SaveState(), world_.SaveState()) << round;
    ExpectSame(world_, *copy, driven_);
    ExpectSame(world_, *copy, box_);
  }
}

TEST_F(WorldCopyTest, TouchesOfABodyAreWithOtherSolidBodies) {
  const World::Body box = AddBox(world_, {0, 0, 0});
  const World::Body neighbour = AddBox(world_, {0.99, 0, 0});
  AddBox(world_, {0, 0.99, 0}, 1.0, Sensor());
  world_.Step(kStep);
  EXPECT_TRUE(world_.contacts().Touches({box}));
  EXPECT_FALSE(world_.contacts().Touches({box, neighbour}));
  EXPECT_FALSE(world_.contacts().Touches({}));
}

}  // namespace
}  // namespace flatland
