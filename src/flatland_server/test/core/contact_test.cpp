/// Contact events: when they are reported, in which order, and their points, normals and impulses.

#include "world/contact.hpp"

#include <gtest/gtest.h>

#include <cmath>
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

TEST_F(ContactTest, OfTwoBodiesThatAreListenedToAreReportedOnceWithTheEventsOfBoth) {
  world_.contacts().ListenTo(AddBox({0, 0, 0}), kBeginContact);
  world_.contacts().ListenTo(AddBox({0.9, 0, 0}), kBeginContact | kPostSolve);

  world_.Step(kStep);

  EXPECT_EQ(recorder_.Story(), "bs");
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
    const bool leaving_is_a = contact.a.body == leaving;
    EXPECT_TRUE((leaving_is_a ? contact.b : contact.a).body == staying);
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
TEST_F(ContactTest, BeginWhenAStaticSensorIsMovedOntoASleepingBodyOrThatOntoIt) {
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

  StepTimes(400);
  ASSERT_FALSE(world_.IsAwake(box));
  world_.SetPose(box, {5, 0.3, 0});
  world_.Step(kStep);
  EXPECT_EQ(recorder_.Story(), "beb");
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

// Along the axes and askew. Two boxes meet side to side, in two points.
TEST_F(ContactTest, HaveTheNormalFromAToB) {
  for (const double towards : {0.0, M_PI_2, M_PI, -M_PI_2, 0.7, -2.5}) {
    for (const char* shapes : {"boxes", "balls", "box and ball", "ball and box"}) {
      SCOPED_TRACE(testing::Message() << shapes << " towards " << towards);
      const bool first_is_box = std::string(shapes).substr(0, 3) == "box";
      const bool second_is_box =
          std::string(shapes).find("box", 3) != std::string::npos || std::string(shapes) == "boxes";
      const Vec2 direction{std::cos(towards), std::sin(towards)};
      const Pose there{0.99 * direction.x, 0.99 * direction.y, towards};
      const World::Body first = first_is_box ? AddBox({0, 0, towards}) : AddBall({0, 0, towards});
      const World::Body second = second_is_box ? AddBox(there) : AddBall(there);
      world_.contacts().ListenTo(first, kBeginContact);

      world_.Step(kStep);

      ASSERT_EQ(recorder_.Story(), "b");
      const Event& event = recorder_.events[0];
      const Vec2 a_to_b = event.a.body == first ? direction : -1.0 * direction;
      EXPECT_NEAR(event.normal.x, a_to_b.x, 1e-5);
      EXPECT_NEAR(event.normal.y, a_to_b.y, 1e-5);
      ASSERT_EQ(event.points.size(), first_is_box && second_is_box ? 2u : 1u);
      if (event.points.size() == 2) {
        const Vec2 apart = event.points[1] - event.points[0];
        EXPECT_NEAR(std::hypot(apart.x, apart.y), 1.0, kSkin);
      }
      const Vec2 left{-direction.y, direction.x};
      for (const Vec2 point : event.points) {
        EXPECT_NEAR(Dot(point, direction), 0.495, kSkin);
        EXPECT_NEAR(std::abs(Dot(point, left)), event.points.size() == 2 ? 0.5 : 0.0, kSkin);
      }
      world_.RemoveBody(first);
      world_.RemoveBody(second);
      recorder_.events.clear();
    }
  }
}

// A box is pressed on a wall with 3 N, and pulled along it with 0.4 N, too weakly to slide.
TEST_F(ContactTest, HaveTheImpulsesOfPressingAndRubbing) {
  world_.contacts().ListenTo(world_.AddLayer({{{-5, 0}, {5, 0}}}, 0xFFFF), kPostSolve | kPreSolve);
  FixtureSettings rough = Solid();
  rough.friction = 1.0;
  const World::Body box = AddBox({0, 0.51, 0}, rough);

  for (int step = 0; step < 400; ++step) {
    world_.ApplyForce(box, {0.4, -3.0});
    world_.Step(kStep);
  }

  const Event& last = recorder_.events.back();
  ASSERT_EQ(last.type, kPostSolve);
  EXPECT_NEAR(Sum(last.impulse.normal_impulses), 3.0 * kStep, 1e-4 * kStep);
  EXPECT_NEAR(std::abs(Sum(last.impulse.tangent_impulses)), 0.4 * kStep, 1e-4 * kStep);
}

}  // namespace
}  // namespace flatland
