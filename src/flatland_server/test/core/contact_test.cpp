/// When contact events are reported: their order, for which bodies, and when bodies are removed.

#include "world/contact.hpp"

#include <gtest/gtest.h>

#include <string>

#include "test_contact.hpp"
#include "world/world.hpp"

namespace flatland {
namespace {

TEST_F(ContactTest, HaveEventsInOrder) {
  const World::Body moving = AddBox({0, 0, 0}, Rubber());
  const World::Body waiting = AddBox({1.5, 0, 0}, Rubber());
  world_.contacts().ListenTo(waiting, kAllContactEvents);
  world_.SetVelocity(moving, {2, 0, 0});

  StepTimes(400);

  // They touch for some steps, each with a pre and a post event.
  const std::string story = recorder_.Story();
  ASSERT_GE(story.size(), 4u) << story;
  EXPECT_EQ(story.front(), 'b');
  EXPECT_EQ(story.back(), 'e');
  for (size_t i = 1; i + 1 < story.size(); i += 2) EXPECT_EQ(story.substr(i, 2), "ps") << story;
  for (const Event& event : recorder_.events) {
    EXPECT_EQ(event.id, recorder_.events[0].id);
    EXPECT_EQ(event.is_touching, event.type != kEndContact);
  }
}

// Box2D finds the time of impact at a wall within the step, and solves the contact once more there.
TEST_F(ContactTest, WithAWallHaveEventsInOrder) {
  world_.contacts().ListenTo(AddWallAt(2.0), kAllContactEvents);
  const World::Body ball = AddBall({0, 0, 0}, Rubber());
  world_.SetVelocity(ball, {3, 0, 0});

  StepTimes(400);

  const std::string story = recorder_.Story();
  ASSERT_GE(story.size(), 4u) << story;
  EXPECT_EQ(story.front(), 'b');
  EXPECT_EQ(story.back(), 'e');
  EXPECT_EQ(recorder_.Count(kBeginContact), 1);
  EXPECT_EQ(recorder_.Count(kEndContact), 1);
  for (size_t i = 0; i < story.size(); ++i) {
    if (story[i] == 's') {
      EXPECT_EQ(story[i - 1], 'p') << story;
    }
  }
  EXPECT_LT(world_.GetVelocity(ball).vx, 0.0);
}

TEST_F(ContactTest, BeginAndEndEachTime) {
  const World::Body ball = AddBall({0, 0, 0}, Rubber());
  AddWallAt(-1.0);
  AddWallAt(1.0);
  world_.contacts().ListenTo(ball, kBeginContact | kEndContact);
  world_.SetVelocity(ball, {2, 0, 0});  // Box2D does not let bounce what is slower than 1 m/s

  StepTimes(500);  // 5 m in a room for 1 m

  EXPECT_EQ(recorder_.Story(), "bebebebebe");
}

TEST_F(ContactTest, OfTwoBodiesThatAreListenedToAreReportedOnce) {
  world_.contacts().ListenTo(AddBox({0, 0, 0}), kBeginContact);
  world_.contacts().ListenTo(AddBox({0.9, 0, 0}), kBeginContact);

  StepTimes(3);

  EXPECT_EQ(recorder_.Story(), "b");
}

TEST_F(ContactTest, HaveOnlyTheChosenEvents) {
  for (const ContactEvents chosen : {+kBeginContact, +kEndContact, +kPreSolve, +kPostSolve,
                                     kBeginContact | kPostSolve, +kNoContactEvents}) {
    const World::Body moving = AddBox({0, 0, 0}, Rubber());
    const World::Body waiting = AddBox({1.5, 0, 0}, Rubber());
    world_.contacts().ListenTo(moving, chosen);
    world_.SetVelocity(moving, {2, 0, 0});

    StepTimes(400);

    ContactEvents reported = kNoContactEvents;
    for (const Event& event : recorder_.events) reported |= event.type;
    EXPECT_EQ(reported, chosen);
    world_.RemoveBody(moving);
    world_.RemoveBody(waiting);
    recorder_.events.clear();
  }
}

TEST_F(ContactTest, HaveTheEventsThatEitherSideHasChosen) {
  const World::Body a = AddBox({0, 0, 0});
  const World::Body b = AddBox({0.9, 0, 0});
  world_.contacts().ListenTo(a, kBeginContact);
  world_.contacts().ListenTo(b, kPostSolve);

  world_.Step(kStep);

  EXPECT_EQ(recorder_.Story(), "bs");
}

TEST_F(ContactTest, AreNotReportedAfterListeningHasStopped) {
  const World::Body box = AddBox({0, 0, 0});
  AddBox({0.9, 0, 0});
  world_.contacts().ListenTo(box, kPreSolve);
  world_.Step(kStep);
  ASSERT_EQ(recorder_.Story(), "p");

  world_.contacts().ListenTo(box, kNoContactEvents);
  world_.Step(kStep);
  EXPECT_EQ(recorder_.Story(), "p");

  world_.contacts().ListenTo(box, kPreSolve);
  world_.contacts().SetListener(nullptr);
  world_.Step(kStep);
  EXPECT_EQ(recorder_.Story(), "p");

  Recorder another;
  world_.contacts().SetListener(&another);
  world_.Step(kStep);
  EXPECT_EQ(recorder_.Story(), "p");
  EXPECT_EQ(another.Story(), "p");
  world_.contacts().SetListener(nullptr);
}

TEST_F(ContactTest, EndWhenABodyIsRemovedWhichStillExistsThen) {
  const World::Body staying = AddBox({0, 0, 0});
  const World::Body leaving = AddBox({0.99, 0.1, 0});
  const World::Drive drive = world_.AddDrive(leaving, {}, {});
  world_.contacts().ListenTo(staying, kBeginContact | kEndContact);
  world_.Step(kStep);
  ASSERT_EQ(recorder_.Story(), "b");
  recorder_.action = [&](Contact& contact) {
    const bool leaving_is_a = AreSame(contact.a.body, leaving);
    EXPECT_TRUE(AreSame((leaving_is_a ? contact.b : contact.a).body, staying));
    EXPECT_TRUE(world_.Contains(leaving));
    EXPECT_NEAR(world_.GetPose(leaving).y, 0.1, 1e-3);
    EXPECT_EQ(world_.GetFixtureCount(leaving), 1);
    EXPECT_EQ(world_.GetSettings(leaving_is_a ? contact.a : contact.b).density, 1.0);
    EXPECT_THROW(world_.Get(drive), GoneError);
    EXPECT_THROW(world_.RemoveBody(leaving), std::logic_error);
    EXPECT_THROW(world_.RemoveBody(staying), std::logic_error);
  };

  world_.RemoveBody(leaving);

  EXPECT_EQ(recorder_.Story(), "be");
  EXPECT_FALSE(world_.Contains(leaving));
  EXPECT_THROW(world_.GetPose(leaving), GoneError);
  EXPECT_NO_THROW(world_.GetPose(staying));
  StepTimes(10);
  EXPECT_EQ(recorder_.Story(), "be");
}

TEST_F(ContactTest, OfABodyThatIsListenedToEndWhenItIsRemoved) {
  AddBox({0, 0, 0});
  const World::Body leaving = AddBox({0.99, 0.1, 0});
  world_.contacts().ListenTo(leaving, kBeginContact | kEndContact);
  world_.Step(kStep);

  world_.RemoveBody(leaving);

  EXPECT_EQ(recorder_.Story(), "be");
  // The next body gets the same slot, but not the chosen events.
  const World::Body next = AddBox({0.99, 0.1, 0});
  ASSERT_EQ(next.index, leaving.index);
  StepTimes(10);
  EXPECT_EQ(recorder_.Story(), "be");
}

TEST_F(ContactTest, AreNotReportedByAWorldThatIsDestroyed) {
  Recorder recorder;
  {
    World world(10, 10);
    for (const double x : {0.0, 0.9}) {
      BodySettings settings;
      settings.pose.x = x;
      const World::Body body = world.AddBody(settings);
      world.AddCircle(body, {0, 0}, 0.5, Solid());
      world.contacts().ListenTo(body, kAllContactEvents);
    }
    world.contacts().SetListener(&recorder);
    world.Step(kStep);
    ASSERT_EQ(recorder.Story(), "bps");
  }
  EXPECT_EQ(recorder.Story(), "bps");
}

// Box2D does not test sleeping bodies against static ones.
TEST_F(ContactTest, BeginWhenAStaticSensorIsMovedOntoASleepingBody) {
  const World::Body box = AddBox({0, 0, 0});
  const World::Body sensor = AddBox({5, 0, 0}, Sensor(), b2_staticBody);
  world_.contacts().ListenTo(sensor, kAllContactEvents);
  StepTimes(400);
  ASSERT_FALSE(world_.IsAwake(box));
  ASSERT_EQ(recorder_.Story(), "");

  world_.SetPose(sensor, {0.5, 0, 0});
  world_.Step(kStep);
  EXPECT_EQ(recorder_.Story(), "b");

  StepTimes(400);
  ASSERT_FALSE(world_.IsAwake(box));
  EXPECT_EQ(recorder_.Story(), "b");

  world_.SetPose(sensor, {5, 0, 0});
  world_.Step(kStep);
  EXPECT_EQ(recorder_.Story(), "be");
}

TEST_F(ContactTest, BeginWhenASleepingBodyIsMovedOntoASensor) {
  const World::Body box = AddBox({0, 0, 0});
  const World::Body sensor = AddBox({5, 0, 0}, Sensor(), b2_staticBody);
  world_.contacts().ListenTo(sensor, kAllContactEvents);
  StepTimes(400);
  ASSERT_FALSE(world_.IsAwake(box));

  world_.SetPose(box, {5, 0.3, 0});
  world_.Step(kStep);

  EXPECT_EQ(recorder_.Story(), "b");
}

TEST_F(ContactTest, PushASleepingBodyOutOfAStaticOneThatIsMovedOntoIt) {
  const World::Body box = AddBox({0, 0, 0});
  const World::Body post = AddBox({5, 0, 0}, Solid(), b2_staticBody);
  StepTimes(400);
  ASSERT_FALSE(world_.IsAwake(box));

  world_.SetPose(post, {0.6, 0, 0});
  StepTimes(400);

  EXPECT_LT(world_.GetPose(box).x, -0.35);
}

}  // namespace
}  // namespace flatland
