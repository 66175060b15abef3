/// Actions of a contact listener on the world during an event: allowed ones and refused ones.

#include <gtest/gtest.h>

#include <functional>
#include <stdexcept>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "test_contact.hpp"
#include "world/contact.hpp"
#include "world/world.hpp"

namespace flatland {
namespace {

/// Expects that a call is refused with a message that has these words.
template <class Call>
void Refuses(const char* name, const char* words, Call call) {
  try {
    call();
    ADD_FAILURE() << name << " was not refused";
  } catch (const std::logic_error& error) {
    EXPECT_EQ(dynamic_cast<const std::invalid_argument*>(&error), nullptr) << name;
    EXPECT_NE(std::string(error.what()).find(words), std::string::npos) << name << error.what();
  }
}

class Listening : public ContactTest {
 protected:
  // Two boxes that meet and part again: this causes all kinds of events.
  Listening() {
    moving_ = AddBox({0, 0, 0}, Rubber());
    waiting_ = AddBox({1.5, 0, 0}, Rubber());
    world_.contacts().ListenTo(waiting_, kAllContactEvents);
    world_.SetVelocity(moving_, {2, 0, 0});
    hinge_ = world_.AddRevolute(AddBody({8, 8, 0}), AddBody({8, 8, 0}), {});
    drive_ = world_.AddDrive(AddBody({9, 9, 0}), {}, {});
  }

  // Expects that each kind of event has occurred, and that nothing has disturbed the boxes.
  void ExpectAllEventsUndisturbed() {
    EXPECT_EQ(recorder_.Count(kBeginContact), 1);
    EXPECT_GE(recorder_.Count(kPreSolve), 1);
    EXPECT_GE(recorder_.Count(kPostSolve), 1);
    EXPECT_EQ(recorder_.Count(kEndContact), 1);
    EXPECT_NEAR(world_.GetVelocity(waiting_).vx, 2.0, 1e-3);
    EXPECT_NEAR(world_.GetVelocity(moving_).vx, 0.0, 1e-3);
    EXPECT_EQ(world_.body_count(), 5);
    EXPECT_EQ(world_.joint_count(), 1);
  }

  World::Body moving_, waiting_;
  World::Joint hinge_;
  World::Drive drive_;
};

TEST_F(Listening, StepsEndAfterOneWithAnEvent) {
  int before = -1;
  recorder_.action = [&](Contact&) { before = world_.completed_steps(); };

  const int steps = world_.StepUntilContact(kStep, 1000);

  EXPECT_GT(steps, 10);
  EXPECT_EQ(before, steps - 1);
  EXPECT_EQ(world_.completed_steps(), steps);
  EXPECT_EQ(recorder_.Count(kBeginContact), 1);
  world_.contacts().ListenTo(waiting_, kNoContactEvents);
  EXPECT_EQ(world_.StepUntilContact(kStep, 50), 50);
  EXPECT_THROW(world_.StepUntilContact(kStep, 0), std::invalid_argument);
}

TEST_F(Listening, MayLookAtTheWorld) {
  recorder_.action = [&](Contact& contact) {
    const double apart = world_.GetPose(waiting_).x - world_.GetPose(moving_).x;
    EXPECT_NEAR(apart, 1.0, 2 * kSkin);
    EXPECT_GE(world_.GetVelocity(moving_).vx + world_.GetLocalVelocity(waiting_).vx, 1.9);
    EXPECT_NEAR(world_.GetVelocityAt(moving_, {0, 0}).y, 0.0, 1e-3);
    EXPECT_NEAR(world_.GetCenter(waiting_).y, 0.0, 1e-3);
    EXPECT_NEAR(world_.ToLocalPoint(moving_, world_.ToWorldPoint(moving_, {1, 2})).y, 2.0, 1e-6);
    EXPECT_NEAR(world_.GetMass(moving_), 1.0, 1e-6);
    EXPECT_NEAR(world_.GetInertia(moving_), 1.0 / 6.0, 1e-6);
    EXPECT_TRUE(world_.IsAwake(moving_));
    EXPECT_EQ(world_.GetType(moving_), b2_dynamicBody);
    EXPECT_EQ(world_.GetFixtureCount(contact.a.body), 1);
    EXPECT_EQ(world_.GetSettings(contact.b).restitution, 1.0);
    EXPECT_TRUE(world_.TestPoint({moving_, 0}, world_.GetCenter(moving_)));
    EXPECT_EQ(world_.GetJointAngle(hinge_), 0.0);
    EXPECT_EQ(world_.Get(drive_).velocity().vx, 0.0);
  };

  StepTimes(400);

  ExpectAllEventsUndisturbed();
}

// Box2D clears all forces at the end of a step; a force applied within it counts for the next.
TEST_F(Listening, MayPushAtAnyEvent) {
  for (const ContactEvent type : {kBeginContact, kPreSolve, kPostSolve, kEndContact}) {
    SCOPED_TRACE(static_cast<int>(type));
    const World::Body pushed = AddBox({-5, 0, 0});
    const World::Body turned = AddBox({-5, 3, 0});
    world_.SetPose(moving_, {0, 0, 0});
    world_.SetPose(waiting_, {1.5, 0, 0});
    world_.SetVelocity(moving_, {2, 0, 0});
    world_.SetVelocity(waiting_, {0, 0, 0});
    recorder_.events.clear();
    recorder_.action = [&](Contact& contact) {
      if (contact.event != type || recorder_.Count(type) > 1) return;
      world_.ApplyForce(pushed, {0, 20});
      world_.ApplyTorque(turned, 4);
      world_.ApplyForce(turned, {6, 0}, Vec2{-5, 3.5});
    };

    StepTimes(400);

    ExpectTwist(world_.GetVelocity(pushed), {0, 20 * kStep, 0}, 1e-3);
    ExpectTwist(world_.GetVelocity(turned), {6 * kStep, 0, (4 - 6 * 0.5) * kStep * 6}, 1e-3);
    world_.RemoveBody(pushed);
    world_.RemoveBody(turned);
  }
}

TEST_F(Listening, MayNotAddRemoveOrPlaceAnything) {
  const std::vector<Vec2> triangle{{0, 0}, {1, 0}, {0, 1}};
  recorder_.action = [&](Contact&) {
    const auto refuses = [](const char* name, const std::function<void()>& call) {
      Refuses(name, "during contact events", call);
    };
    refuses("AddLayer", [&] { world_.AddLayer(std::vector<Segment>{{{5, 5}, {6, 6}}}, 1); });
    refuses("AddBody", [&] { world_.AddBody({}); });
    refuses("RemoveBody", [&] { world_.RemoveBody(moving_); });
    refuses("RemoveBody", [&] { world_.RemoveBody(waiting_); });
    refuses("AddCircle", [&] { world_.AddCircle(moving_, Vec2{}, 1.0, Solid()); });
    refuses("AddPolygon", [&] { world_.AddPolygon(waiting_, triangle, Solid()); });
    refuses("SetCircle", [&] { world_.SetCircle(Fixture{moving_, 0}, Vec2{}, 1.0); });
    refuses("AddRevolute", [&] { world_.AddRevolute(moving_, waiting_, {}); });
    refuses("AddWeld", [&] { world_.AddWeld(moving_, waiting_, {}); });
    refuses("AddDrive", [&] { world_.AddDrive(moving_, {}, {}); });
    refuses("AddTween", [&] { world_.AddTween(moving_, {}); });
    refuses("AddTricycle", [&] { world_.AddTricycle(moving_, hinge_, {}); });
    refuses("AddAckermann", [&] { world_.AddAckermann(moving_, {hinge_}, {}); });
    refuses("SetPose", [&] { world_.SetPose(moving_, Pose{3, 3, 0}); });
    refuses("SetContactListener", [&] { world_.contacts().SetListener(nullptr); });
    refuses("Step", [&] { world_.Step(kStep); });
  };

  StepTimes(400);

  ExpectAllEventsUndisturbed();
  EXPECT_NO_THROW(world_.RemoveBody(moving_));
}

// As for a plugin that is switched off because it raised an exception.
TEST_F(Listening, MayStopListening) {
  recorder_.action = [&](Contact& contact) {
    if (contact.event == kPreSolve) world_.contacts().ListenTo(waiting_, kNoContactEvents);
  };

  StepTimes(400);

  EXPECT_EQ(recorder_.Story(), "bp");
  EXPECT_NEAR(world_.GetVelocity(waiting_).vx, 2.0, 1e-3);
}

// Other threads have access again as soon as the step is over.
TEST_F(Listening, IsSafeFromOtherThreads) {
  const auto refuse = [](const char* name, const std::function<void()>& touch) {
    Refuses(name, "the world is in use by another thread", touch);
  };
  recorder_.action = [&](Contact&) {
    std::thread([&] {
      refuse("pose", [&] { world_.GetPose(moving_); });
      refuse("velocity", [&] { world_.SetVelocity(moving_, {9, 0, 0}); });
      refuse("force", [&] { world_.ApplyForce(moving_, {9, 0}); });
      refuse("fixture", [&] { world_.GetSettings({moving_, 0}); });
      refuse("fixtures", [&] { world_.GetFixtureCount(moving_); });
      refuse("joint", [&] { world_.GetJointAngle(hinge_); });
      refuse("drive", [&] { world_.Get(drive_); });
      refuse("place", [&] { world_.SetPose(moving_, {}); });
      refuse("add", [&] { world_.AddBody({}); });
      refuse("remove", [&] { world_.RemoveBody(moving_); });
      refuse("listen", [&] { world_.contacts().ListenTo(moving_, 0); });
      refuse("step", [&] { world_.Step(kStep); });
    }).join();
  };

  StepTimes(400);

  ExpectAllEventsUndisturbed();
  std::thread([&] { EXPECT_NO_THROW(world_.GetPose(moving_)); }).join();
}

}  // namespace
}  // namespace flatland
