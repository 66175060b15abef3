#include "flatland_server/contact.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <limits>
#include <numeric>
#include <stdexcept>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "flatland_server/world.hpp"

namespace flatland {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kStep = 0.005;
constexpr double kSkin = 0.02;  // Box2D's rounded corners and slop [m]
constexpr uint8_t kAllHooks = kBeginContact | kEndContact | kPreSolve | kPostSolve;

/// What was told of a contact at one of its moments.
struct Event {
  ContactHooks moment;
  Fixture a, b;
  const void* id;
  bool is_touching, is_enabled;
  std::vector<Vec2> points;
  Vec2 normal;
  Manifold old_manifold;
  ContactImpulse impulse;
};

double Sum(const std::vector<double>& values) {
  return std::accumulate(values.begin(), values.end(), 0.0);
}

/// Writes down all it hears, and does what the test wants done.
class Recorder : public ContactListener {
 public:
  void OnContact(Contact& contact) override {
    events.push_back({contact.moment, contact.a, contact.b, contact.id(), contact.is_touching(),
                      contact.is_enabled(), contact.Points(), contact.Normal(),
                      contact.old_manifold, contact.impulse});
    if (action) action(contact);
  }

  // A letter for each event: (b)egin, (p)re solve, post (s)olve, (e)nd.
  std::string Story() const {
    std::string story;
    for (const Event& event : events) {
      story += event.moment == kBeginContact ? 'b'
               : event.moment == kEndContact ? 'e'
               : event.moment == kPreSolve   ? 'p'
                                             : 's';
    }
    return story;
  }

  int Count(ContactHooks moment) const {
    int count = 0;
    for (const Event& event : events) count += event.moment == moment;
    return count;
  }

  double TotalNormalImpulse() const {
    double total = 0.0;
    for (const Event& event : events) total += Sum(event.impulse.normal_impulses);
    return total;
  }

  std::vector<Event> events;
  std::function<void(Contact&)> action;
};

FixtureSettings Solid() {
  FixtureSettings settings;
  settings.density = 1.0;
  return settings;
}

FixtureSettings Rubber() {
  FixtureSettings settings = Solid();
  settings.restitution = 1.0;
  return settings;
}

FixtureSettings Sensor() {
  FixtureSettings settings = Solid();
  settings.sensor = true;
  return settings;
}

void ExpectTwist(const Twist& twist, const Twist& expected) {
  EXPECT_NEAR(twist.vx, expected.vx, 1e-3);
  EXPECT_NEAR(twist.vy, expected.vy, 1e-3);
  EXPECT_NEAR(twist.omega, expected.omega, 1e-3);
}

bool AreSame(World::Body a, World::Body b) {
  return a.index == b.index && a.generation == b.generation;
}

class ContactTest : public testing::Test {
 protected:
  ContactTest() { world_.SetContactListener(&heard_); }

  World::Body AddBody(const Pose& pose, b2BodyType type = b2_dynamicBody) {
    BodySettings settings;
    settings.type = type;
    settings.pose = pose;
    return world_.AddBody(settings);
  }

  World::Body AddBox(const Pose& pose, const FixtureSettings& settings = Solid(),
                     b2BodyType type = b2_dynamicBody) {
    const World::Body box = AddBody(pose, type);
    world_.AddPolygon(box, {{-0.5, -0.5}, {0.5, -0.5}, {0.5, 0.5}, {-0.5, 0.5}}, settings);
    return box;
  }

  World::Body AddBall(const Pose& pose, const FixtureSettings& settings = Solid()) {
    const World::Body ball = AddBody(pose);
    world_.AddCircle(ball, {0, 0}, 0.5, settings);
    return ball;
  }

  World::Body AddWallAt(double x) { return world_.AddLayer({{{x, -5}, {x, 5}}}, 0xFFFF); }

  void StepTimes(int steps) {
    for (int step = 0; step < steps; ++step) world_.Step(kStep);
  }

  Recorder heard_;
  World world_{10, 10};
};

using Contacts = ContactTest;

TEST_F(Contacts, AreToldOfInOrder) {
  const World::Body moving = AddBox({0, 0, 0}, Rubber());
  const World::Body waiting = AddBox({1.5, 0, 0}, Rubber());
  world_.ListenTo(waiting, kAllHooks);
  world_.SetVelocity(moving, {2, 0, 0});

  StepTimes(400);

  // They touch for some steps, each with its pre and its post.
  const std::string story = heard_.Story();
  ASSERT_GE(story.size(), 4u) << story;
  EXPECT_EQ(story.front(), 'b');
  EXPECT_EQ(story.back(), 'e');
  for (size_t i = 1; i + 1 < story.size(); i += 2) EXPECT_EQ(story.substr(i, 2), "ps") << story;
  for (const Event& event : heard_.events) {
    EXPECT_EQ(event.id, heard_.events[0].id);
    EXPECT_EQ(event.is_touching, event.moment != kEndContact);
  }
}

// A wall is met between steps, where Box2D solves what touches once more.
TEST_F(Contacts, WithAWallAreToldOfInOrder) {
  world_.ListenTo(AddWallAt(2.0), kAllHooks);
  const World::Body ball = AddBall({0, 0, 0}, Rubber());
  world_.SetVelocity(ball, {3, 0, 0});

  StepTimes(400);

  const std::string story = heard_.Story();
  ASSERT_GE(story.size(), 4u) << story;
  EXPECT_EQ(story.front(), 'b');
  EXPECT_EQ(story.back(), 'e');
  EXPECT_EQ(heard_.Count(kBeginContact), 1);
  EXPECT_EQ(heard_.Count(kEndContact), 1);
  for (size_t i = 0; i < story.size(); ++i) {
    if (story[i] == 's') {
      EXPECT_EQ(story[i - 1], 'p') << story;
    }
  }
  EXPECT_LT(world_.GetVelocity(ball).vx, 0.0);
}

TEST_F(Contacts, AreToldOfAgainWhenTheyHappenAgain) {
  const World::Body ball = AddBall({0, 0, 0}, Rubber());
  AddWallAt(-1.0);
  AddWallAt(1.0);
  world_.ListenTo(ball, kBeginContact | kEndContact);
  world_.SetVelocity(ball, {2, 0, 0});  // Box2D does not let bounce what is slower than 1 m/s

  StepTimes(500);  // 5 m in a room for 1 m

  EXPECT_EQ(heard_.Story(), "bebebebebe");
}

TEST_F(Contacts, OfBodiesThatNobodyListensToAreNotToldOf) {
  const World::Body unheard = AddBox({0, 0, 0});
  AddBox({0.9, 0, 0});
  const World::Body heard = AddBox({0, 3, 0});
  const World::Body partner = AddBox({0.9, 3, 0});
  world_.ListenTo(heard, kAllHooks);
  world_.ListenTo(unheard, kNoHooks);

  StepTimes(10);

  ASSERT_GT(heard_.events.size(), 2u);
  for (const Event& event : heard_.events) {
    EXPECT_TRUE(AreSame(event.a.body, heard) || AreSame(event.b.body, heard));
    EXPECT_TRUE(AreSame(event.a.body, partner) || AreSame(event.b.body, partner));
  }
}

TEST_F(Contacts, OfTwoBodiesThatAreListenedToAreToldOfOnce) {
  world_.ListenTo(AddBox({0, 0, 0}), kBeginContact);
  world_.ListenTo(AddBox({0.9, 0, 0}), kBeginContact);

  StepTimes(3);

  EXPECT_EQ(heard_.Story(), "b");
}

TEST_F(Contacts, AreToldOfAtTheMomentsAskedFor) {
  for (const uint8_t hooks : {+kBeginContact, +kEndContact, +kPreSolve, +kPostSolve,
                              kBeginContact | kPostSolve, +kNoHooks}) {
    const World::Body moving = AddBox({0, 0, 0}, Rubber());
    const World::Body waiting = AddBox({1.5, 0, 0}, Rubber());
    world_.ListenTo(moving, hooks);
    world_.SetVelocity(moving, {2, 0, 0});

    StepTimes(400);

    uint8_t told = kNoHooks;
    for (const Event& event : heard_.events) told |= event.moment;
    EXPECT_EQ(told, hooks);
    world_.RemoveBody(moving);
    world_.RemoveBody(waiting);
    heard_.events.clear();
  }
}

TEST_F(Contacts, AreToldOfAtTheMomentsThatEitherSideAsksFor) {
  const World::Body a = AddBox({0, 0, 0});
  const World::Body b = AddBox({0.9, 0, 0});
  world_.ListenTo(a, kBeginContact);
  world_.ListenTo(b, kPostSolve);

  world_.Step(kStep);

  EXPECT_EQ(heard_.Story(), "bs");
}

TEST_F(Contacts, AreNoLongerToldOfOnceNobodyListens) {
  const World::Body box = AddBox({0, 0, 0});
  AddBox({0.9, 0, 0});
  world_.ListenTo(box, kPreSolve);
  world_.Step(kStep);
  ASSERT_EQ(heard_.Story(), "p");

  world_.ListenTo(box, kNoHooks);
  world_.Step(kStep);
  EXPECT_EQ(heard_.Story(), "p");

  world_.ListenTo(box, kPreSolve);
  world_.SetContactListener(nullptr);
  world_.Step(kStep);
  EXPECT_EQ(heard_.Story(), "p");

  Recorder another;
  world_.SetContactListener(&another);
  world_.Step(kStep);
  EXPECT_EQ(heard_.Story(), "p");
  EXPECT_EQ(another.Story(), "p");
  world_.SetContactListener(nullptr);
}

TEST_F(Contacts, NameTheWallOfALayer) {
  const World::Body layer =
      world_.AddLayer({{{-5, 9}, {5, 9}}, {{-5, -9}, {5, -9}}, {{2, -5}, {2, 5}}}, 0xFFFF);
  const World::Body box = AddBox({1.55, 0, 0});
  world_.ListenTo(layer, kBeginContact);

  world_.Step(kStep);

  ASSERT_EQ(heard_.Story(), "b");
  const Event& event = heard_.events[0];
  const bool layer_is_a = AreSame(event.a.body, layer);
  EXPECT_EQ((layer_is_a ? event.a : event.b).index, 2u);
  EXPECT_TRUE(AreSame((layer_is_a ? event.b : event.a).body, box));
}

TEST_F(Contacts, NameTheFixtureOfABody) {
  const World::Body robot = AddBody({0, 0, 0});
  const Fixture left = world_.AddCircle(robot, {0, 2}, 0.5, Solid());
  const Fixture front = world_.AddCircle(robot, {2, 0}, 0.5, Solid());
  world_.AddCircle(robot, {0, -2}, 0.5, Solid());
  const World::Body other = AddBall({2.9, 0, 0});
  world_.ListenTo(other, kBeginContact);

  world_.Step(kStep);

  ASSERT_EQ(heard_.Story(), "b");
  const Event& event = heard_.events[0];
  const Fixture of_robot = AreSame(event.a.body, robot) ? event.a : event.b;
  EXPECT_TRUE(AreSame(of_robot.body, robot));
  EXPECT_EQ(of_robot.index, front.index);
  EXPECT_NE(of_robot.index, left.index);
}

TEST_F(Contacts, WithASensorBeginAndEndWithoutPoints) {
  const World::Body sensor = AddBox({2, 0, 0}, Sensor(), b2_staticBody);
  const World::Body box = AddBox({0, 0, 0});
  world_.ListenTo(sensor, kAllHooks);
  world_.SetVelocity(box, {2, 0, 0});

  StepTimes(400);

  EXPECT_EQ(heard_.Story(), "be");
  for (const Event& event : heard_.events) {
    EXPECT_FALSE(event.is_enabled);
    EXPECT_TRUE(event.points.empty());
    EXPECT_EQ(event.normal.x, 0.0);
    EXPECT_EQ(event.normal.y, 0.0);
  }
  EXPECT_NEAR(world_.GetPose(box).x, 4.0, 1e-4);
}

// Straight and askew; as polygons the two meet flat, in a line of two points.
TEST_F(Contacts, HaveTheNormalFromAToB) {
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
      world_.ListenTo(first, kBeginContact);

      world_.Step(kStep);

      ASSERT_EQ(heard_.Story(), "b");
      const Event& event = heard_.events[0];
      const Vec2 a_to_b = AreSame(event.a.body, first) ? direction : -1.0 * direction;
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
      heard_.events.clear();
    }
  }
}

TEST_F(Contacts, HaveTheNormalFromTheWallOrTowardsIt) {
  const World::Body layer = AddWallAt(0.0);
  for (const double side : {1.0, -1.0}) {
    const World::Body ball = AddBall({0.49 * side, 1.0, 0});
    world_.ListenTo(ball, kBeginContact);

    world_.Step(kStep);

    ASSERT_EQ(heard_.Story(), "b");
    const Event& event = heard_.events[0];
    const double from_layer = AreSame(event.a.body, layer) ? side : -side;
    EXPECT_NEAR(event.normal.x, from_layer, 1e-5);
    EXPECT_NEAR(event.normal.y, 0.0, 1e-5);
    ASSERT_EQ(event.points.size(), 1u);
    EXPECT_NEAR(event.points[0].x, 0.0, kSkin);
    EXPECT_NEAR(event.points[0].y, 1.0, 1e-3);
    world_.RemoveBody(ball);
    heard_.events.clear();
  }
}

// Newton's third law: what one loses, over all the steps of the touch, the other gets.
TEST_F(Contacts, HaveTheImpulsesOfAHeadOnHit) {
  for (const double restitution : {0.0, 0.5}) {
    SCOPED_TRACE(restitution);
    FixtureSettings material = Solid();
    material.restitution = restitution;
    const World::Body moving = AddBox({0, 0, 0}, material);
    const World::Body waiting = AddBox({1.5, 0, 0}, material);
    world_.ListenTo(moving, kPostSolve);
    world_.SetVelocity(moving, {4, 0, 0});

    StepTimes(200);

    // Of the same mass m: m v (1 + e) / 2.
    const double expected = world_.GetMass(moving) * 4.0 * (1.0 + restitution) / 2.0;
    EXPECT_NEAR(heard_.TotalNormalImpulse(), expected, 1e-3);
    EXPECT_NEAR(world_.GetMass(waiting) * world_.GetVelocity(waiting).vx, expected, 1e-3);
    world_.RemoveBody(moving);
    world_.RemoveBody(waiting);
    heard_.events.clear();
  }
}

TEST_F(Contacts, HaveTheImpulsesOfAHitAtAWall) {
  world_.ListenTo(AddWallAt(2.0), kPostSolve);
  const World::Body box = AddBox({0, 0, 0});
  world_.SetVelocity(box, {4, 0, 0});

  StepTimes(200);

  EXPECT_NEAR(heard_.TotalNormalImpulse(), world_.GetMass(box) * 4.0, 1e-3);
  for (const Event& event : heard_.events) {
    EXPECT_EQ(event.impulse.normal_impulses.size(), 2u);
    EXPECT_EQ(event.impulse.tangent_impulses.size(), 2u);
  }
}

// A box is pressed on a wall with 3 N and drawn along it, too weakly to slide: 0.4 N.
TEST_F(Contacts, HaveTheImpulsesOfPressingAndRubbing) {
  world_.ListenTo(world_.AddLayer({{{-5, 0}, {5, 0}}}, 0xFFFF), kPostSolve | kPreSolve);
  FixtureSettings rough = Solid();
  rough.friction = 1.0;
  const World::Body box = AddBox({0, 0.51, 0}, rough);

  for (int step = 0; step < 400; ++step) {
    world_.ApplyForce(box, {0.4, -3.0});
    world_.Step(kStep);
  }

  const Event& last = heard_.events.back();
  ASSERT_EQ(last.moment, kPostSolve);
  EXPECT_NEAR(Sum(last.impulse.normal_impulses), 3.0 * kStep, 1e-4 * kStep);
  EXPECT_NEAR(std::abs(Sum(last.impulse.tangent_impulses)), 0.4 * kStep, 1e-4 * kStep);
}

TEST_F(Contacts, KnowTheirPointsAndImpulsesOfTheStepBefore) {
  const World::Body box = AddBox({0, 0, 0});
  world_.ListenTo(AddWallAt(0.51), kPreSolve | kPostSolve);
  for (int step = 0; step < 100; ++step) {
    world_.ApplyForce(box, {3.0, 0.0});
    world_.Step(kStep);
  }

  ASSERT_EQ(heard_.events[0].moment, kPreSolve);
  EXPECT_TRUE(heard_.events[0].old_manifold.local_points.empty());
  const size_t count = heard_.events.size();
  const Event &before = heard_.events[count - 3], &pre = heard_.events[count - 2];
  ASSERT_EQ(before.moment, kPostSolve);
  ASSERT_EQ(pre.moment, kPreSolve);
  ASSERT_EQ(pre.old_manifold.local_points.size(), 2u);
  EXPECT_EQ(pre.old_manifold.normal_impulses, before.impulse.normal_impulses);
  EXPECT_EQ(pre.old_manifold.tangent_impulses, before.impulse.tangent_impulses);
  for (const Vec2 point : pre.old_manifold.local_points) {
    EXPECT_NEAR(std::abs(point.x), 0.5, kSkin);
  }
}

TEST_F(Contacts, SwitchedOffBeforeTheyAreSolvedLetABodyPass) {
  for (const char* obstacle : {"a box", "a wall"}) {
    SCOPED_TRACE(obstacle);
    const bool is_box = std::string(obstacle) == "a box";
    const double y = is_box ? 0.0 : 20.0;
    const World::Body waiting =
        is_box ? AddBox({2, y, 0}) : world_.AddLayer({{{2, y - 5}, {2, y + 5}}}, 0xFFFF);
    const World::Body thrown = AddBox({0, y, 0});
    const World::Body driven = AddBox({-3, y, 0});
    world_.ListenTo(waiting, kAllHooks);
    world_.SetVelocity(thrown, {2, 0, 0});
    world_.Get(world_.AddDrive(driven, {}, {})).Command({2, 0, 0});
    heard_.action = [](Contact& contact) {
      if (contact.moment != kPreSolve) return;
      EXPECT_TRUE(contact.is_enabled());
      contact.SetEnabled(false);
      EXPECT_FALSE(contact.is_enabled());
    };

    StepTimes(800);

    EXPECT_NEAR(world_.GetPose(thrown).x, 8.0, 1e-4);
    EXPECT_NEAR(world_.GetPose(driven).x, 5.0, 1e-4);
    EXPECT_NEAR(world_.GetVelocity(thrown).vx, 2.0, 1e-6);
    EXPECT_EQ(world_.GetPose(waiting).x, is_box ? 2.0 : 0.0);
    EXPECT_EQ(heard_.Count(kBeginContact), 2);
    EXPECT_EQ(heard_.Count(kEndContact), 2);
    EXPECT_EQ(heard_.Count(kPostSolve), 0);
    heard_.events.clear();
  }
}

TEST_F(Contacts, SwitchedOffAreOnAgainInTheNextStep) {
  const World::Body waiting = AddBox({1.02, 0, 0});
  const World::Body moving = AddBox({0, 0, 0});
  world_.ListenTo(waiting, kPreSolve);
  world_.SetVelocity(moving, {2, 0, 0});
  heard_.action = [&](Contact& contact) {
    if (heard_.Count(kPreSolve) <= 5) contact.SetEnabled(false);
  };

  StepTimes(100);

  EXPECT_GT(world_.GetVelocity(waiting).vx, 0.9);
}

TEST_F(Contacts, TakeARestitutionAFrictionAndASpeedOfTheirOwn) {
  AddWallAt(2.0);
  const World::Body ball = AddBall({0, 0, 0});
  world_.ListenTo(ball, kPreSolve);
  world_.SetVelocity(ball, {3, 0, 0});
  heard_.action = [](Contact& contact) {
    EXPECT_EQ(contact.friction(), 0.0);
    contact.SetRestitution(0.5);
    EXPECT_EQ(contact.restitution(), 0.5);
  };

  StepTimes(400);

  EXPECT_NEAR(world_.GetVelocity(ball).vx, -1.5, 1e-3);
}

// A box lies on a conveyor belt that runs at 0.3 m/s to the right.
TEST_F(Contacts, CarryABodyAlongAMovingSurface) {
  const World::Body belt = world_.AddLayer({{{-9, 0}, {9, 0}}}, 0xFFFF);
  const World::Body box = AddBox({0, 0.51, 0});
  world_.ListenTo(belt, kPreSolve);
  heard_.action = [&](Contact& contact) {
    contact.SetFriction(1.0);
    contact.SetTangentSpeed(AreSame(contact.a.body, belt) ? 0.3 : -0.3);
    EXPECT_NEAR(std::abs(contact.tangent_speed()), 0.3, 1e-6);
    EXPECT_EQ(contact.friction(), 1.0);
  };

  for (int step = 0; step < 400; ++step) {
    world_.ApplyForce(box, {0, -5});
    world_.Step(kStep);
  }

  EXPECT_NEAR(std::abs(world_.GetVelocity(box).vx), 0.3, 0.01);
}

TEST_F(Contacts, RefuseValuesThatAreNotFiniteOrNegative) {
  AddBox({0, 0, 0});
  world_.ListenTo(AddBox({0.9, 0, 0}), kBeginContact);
  heard_.action = [](Contact& contact) {
    for (const double bad : {-0.1, kNaN, kInfinity}) {
      EXPECT_THROW(contact.SetFriction(bad), std::invalid_argument) << bad;
      EXPECT_THROW(contact.SetRestitution(bad), std::invalid_argument) << bad;
    }
    EXPECT_THROW(contact.SetTangentSpeed(kNaN), std::invalid_argument);
    EXPECT_THROW(contact.SetTangentSpeed(-kInfinity), std::invalid_argument);
  };

  StepTimes(10);

  EXPECT_EQ(heard_.Story(), "b");
}

class Listening : public ContactTest {
 protected:
  // Something for each moment: two boxes that meet and part again.
  Listening() {
    moving_ = AddBox({0, 0, 0}, Rubber());
    waiting_ = AddBox({1.5, 0, 0}, Rubber());
    world_.ListenTo(waiting_, kAllHooks);
    world_.SetVelocity(moving_, {2, 0, 0});
    hinge_ = world_.AddRevolute(AddBody({8, 8, 0}), AddBody({8, 8, 0}), {});
    drive_ = world_.AddDrive(AddBody({9, 9, 0}), {}, {});
  }

  // Expects that each moment has come, and that nothing has disturbed the boxes.
  void ExpectAllAsEver() {
    EXPECT_EQ(heard_.Count(kBeginContact), 1);
    EXPECT_GE(heard_.Count(kPreSolve), 1);
    EXPECT_GE(heard_.Count(kPostSolve), 1);
    EXPECT_EQ(heard_.Count(kEndContact), 1);
    EXPECT_NEAR(world_.GetVelocity(waiting_).vx, 2.0, 1e-3);
    EXPECT_NEAR(world_.GetVelocity(moving_).vx, 0.0, 1e-3);
    EXPECT_EQ(world_.body_count(), 5);
    EXPECT_EQ(world_.joint_count(), 1);
  }

  World::Body moving_, waiting_;
  World::Joint hinge_;
  World::Drive drive_;
};

TEST_F(Listening, MayLookAtTheWorld) {
  heard_.action = [&](Contact& contact) {
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
    EXPECT_EQ(world_.JointAngle(hinge_), 0.0);
    EXPECT_EQ(world_.Get(drive_).velocity().vx, 0.0);
  };

  StepTimes(400);

  ExpectAllAsEver();
}

TEST_F(Listening, MayPushAndSetVelocities) {
  heard_.action = [&](Contact& contact) {
    if (contact.moment != kBeginContact) return;
    world_.ApplyForce(waiting_, {0, 20});
    world_.ApplyLinearImpulse(moving_, {0, -0.3});
    world_.Get(drive_).Command({1, 0, 0});
  };

  StepTimes(400);

  // 20 N on 1 kg for a step.
  EXPECT_NEAR(world_.GetVelocity(waiting_).vy, 20 * kStep, 1e-3);
  EXPECT_NEAR(world_.GetVelocity(moving_).vy, -0.3, 1e-3);
  EXPECT_GT(world_.Get(drive_).velocity().vx, 0.0);
}

// Box2D forgets the forces of a step once it is over; one that is given within it is for the next.
TEST_F(Listening, MayPushAtAnyMoment) {
  for (const ContactHooks moment : {kBeginContact, kPreSolve, kPostSolve, kEndContact}) {
    SCOPED_TRACE(static_cast<int>(moment));
    const World::Body pushed = AddBox({-5, 0, 0});
    const World::Body turned = AddBox({-5, 3, 0});
    world_.SetPose(moving_, {0, 0, 0});
    world_.SetPose(waiting_, {1.5, 0, 0});
    world_.SetVelocity(moving_, {2, 0, 0});
    world_.SetVelocity(waiting_, {0, 0, 0});
    heard_.events.clear();
    heard_.action = [&](Contact& contact) {
      if (contact.moment != moment || heard_.Count(moment) > 1) return;
      world_.ApplyForce(pushed, {0, 20});
      world_.ApplyTorque(turned, 4);
      world_.ApplyForce(turned, {6, 0}, Vec2{-5, 3.5});
    };

    StepTimes(400);

    ExpectTwist(world_.GetVelocity(pushed), {0, 20 * kStep, 0});
    ExpectTwist(world_.GetVelocity(turned), {6 * kStep, 0, (4 - 6 * 0.5) * kStep * 6});
    world_.RemoveBody(pushed);
    world_.RemoveBody(turned);
  }
}

TEST_F(Listening, MayNotAddRemoveOrPlaceAnything) {
  int refusals = 0;
  const std::vector<std::pair<const char*, std::function<void()>>> attempts = {
      {"AddLayer",
       [&] {
         world_.AddLayer({{{5, 5}, {6, 6}}}, 1);
       }},
      {"AddBody", [&] { world_.AddBody({}); }},
      {"RemoveBody", [&] { world_.RemoveBody(moving_); }},
      {"RemoveBody", [&] { world_.RemoveBody(waiting_); }},
      {"AddCircle",
       [&] {
         world_.AddCircle(moving_, {0, 0}, 1.0, Solid());
       }},
      {"AddPolygon",
       [&] {
         world_.AddPolygon(waiting_, {{0, 0}, {1, 0}, {0, 1}}, Solid());
       }},
      {"AddRevolute", [&] { world_.AddRevolute(moving_, waiting_, {}); }},
      {"AddWeld", [&] { world_.AddWeld(moving_, waiting_, {}); }},
      {"AddDrive", [&] { world_.AddDrive(moving_, {}, {}); }},
      {"AddTween", [&] { world_.AddTween(moving_, {}); }},
      {"AddTricycle", [&] { world_.AddTricycle(moving_, hinge_, {}); }},
      {"SetPose",
       [&] {
         world_.SetPose(moving_, {3, 3, 0});
       }},
      {"SetContactListener", [&] { world_.SetContactListener(nullptr); }},
      {"Step", [&] { world_.Step(kStep); }},
  };
  heard_.action = [&](Contact&) {
    for (const auto& [name, attempt] : attempts) {
      try {
        attempt();
        ADD_FAILURE() << name << " was not refused";
      } catch (const std::invalid_argument& error) {
        ADD_FAILURE() << name << ": " << error.what();
      } catch (const std::logic_error& error) {
        EXPECT_NE(std::string(error.what()).find("while contacts are told of"), std::string::npos)
            << name << ": " << error.what();
        ++refusals;
      }
    }
  };

  StepTimes(400);

  ExpectAllAsEver();
  EXPECT_EQ(refusals, static_cast<int>(attempts.size() * heard_.events.size()));
  EXPECT_NO_THROW(world_.RemoveBody(moving_));
}

// As for a plugin that is switched off because it raised an exception.
TEST_F(Listening, MayListenNoMore) {
  heard_.action = [&](Contact& contact) {
    if (contact.moment == kPreSolve) world_.ListenTo(waiting_, kNoHooks);
  };

  StepTimes(400);

  EXPECT_EQ(heard_.Story(), "bp");
  EXPECT_NEAR(world_.GetVelocity(waiting_).vx, 2.0, 1e-3);
}

// The other thread is let in again as soon as the step is over.
TEST_F(Listening, LetsNoOtherThreadIn) {
  const auto refuse = [&](const char* name, const std::function<void()>& touch) {
    try {
      touch();
      ADD_FAILURE() << name << " was not refused";
    } catch (const std::logic_error& error) {
      EXPECT_STREQ(error.what(), "the world is in use by another thread") << name;
    }
  };
  heard_.action = [&](Contact&) {
    std::thread([&] {
      refuse("pose", [&] { world_.GetPose(moving_); });
      refuse("velocity", [&] { world_.SetVelocity(moving_, {9, 0, 0}); });
      refuse("force", [&] { world_.ApplyForce(moving_, {9, 0}); });
      refuse("fixture", [&] { world_.GetSettings({moving_, 0}); });
      refuse("fixtures", [&] { world_.GetFixtureCount(moving_); });
      refuse("joint", [&] { world_.JointAngle(hinge_); });
      refuse("drive", [&] { world_.Get(drive_); });
      refuse("place", [&] { world_.SetPose(moving_, {}); });
      refuse("add", [&] { world_.AddBody({}); });
      refuse("remove", [&] { world_.RemoveBody(moving_); });
      refuse("listen", [&] { world_.ListenTo(moving_, 0); });
      refuse("step", [&] { world_.Step(kStep); });
    }).join();
  };

  StepTimes(400);

  ExpectAllAsEver();
  std::thread([&] { EXPECT_NO_THROW(world_.GetPose(moving_)); }).join();
}

TEST_F(Contacts, EndWhenABodyIsRemovedThatCanStillBeLookedAt) {
  const World::Body staying = AddBox({0, 0, 0});
  const World::Body leaving = AddBox({0.99, 0.1, 0});
  const World::Drive drive = world_.AddDrive(leaving, {}, {});
  world_.ListenTo(staying, kBeginContact | kEndContact);
  world_.Step(kStep);
  ASSERT_EQ(heard_.Story(), "b");
  heard_.action = [&](Contact& contact) {
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

  EXPECT_EQ(heard_.Story(), "be");
  EXPECT_FALSE(world_.Contains(leaving));
  EXPECT_THROW(world_.GetPose(leaving), GoneError);
  EXPECT_NO_THROW(world_.GetPose(staying));
  StepTimes(10);
  EXPECT_EQ(heard_.Story(), "be");
}

TEST_F(Contacts, OfABodyThatIsListenedToEndWhenItIsRemoved) {
  AddBox({0, 0, 0});
  const World::Body leaving = AddBox({0.99, 0.1, 0});
  world_.ListenTo(leaving, kBeginContact | kEndContact);
  world_.Step(kStep);

  world_.RemoveBody(leaving);

  EXPECT_EQ(heard_.Story(), "be");
  // What takes its place is another body, and nobody listens to that.
  const World::Body next = AddBox({0.99, 0.1, 0});
  ASSERT_EQ(next.index, leaving.index);
  StepTimes(10);
  EXPECT_EQ(heard_.Story(), "be");
}

TEST_F(Contacts, AreNotToldOfByAWorldThatGoes) {
  Recorder heard;
  {
    World world(10, 10);
    for (const double x : {0.0, 0.9}) {
      BodySettings settings;
      settings.pose.x = x;
      const World::Body body = world.AddBody(settings);
      world.AddCircle(body, {0, 0}, 0.5, Solid());
      world.ListenTo(body, kAllHooks);
    }
    world.SetContactListener(&heard);
    world.Step(kStep);
    ASSERT_EQ(heard.Story(), "bps");
  }
  EXPECT_EQ(heard.Story(), "bps");
}

// Box2D does not compare a sleeping body with what is static.
TEST_F(Contacts, BeginWhenAStaticSensorIsMovedOntoASleepingBody) {
  const World::Body box = AddBox({0, 0, 0});
  const World::Body sensor = AddBox({5, 0, 0}, Sensor(), b2_staticBody);
  world_.ListenTo(sensor, kAllHooks);
  StepTimes(400);
  ASSERT_FALSE(world_.IsAwake(box));
  ASSERT_EQ(heard_.Story(), "");

  world_.SetPose(sensor, {0.5, 0, 0});
  world_.Step(kStep);
  EXPECT_EQ(heard_.Story(), "b");

  StepTimes(400);
  ASSERT_FALSE(world_.IsAwake(box));
  EXPECT_EQ(heard_.Story(), "b");

  world_.SetPose(sensor, {5, 0, 0});
  world_.Step(kStep);
  EXPECT_EQ(heard_.Story(), "be");
}

TEST_F(Contacts, BeginWhenASleepingBodyIsMovedOntoASensor) {
  const World::Body box = AddBox({0, 0, 0});
  const World::Body sensor = AddBox({5, 0, 0}, Sensor(), b2_staticBody);
  world_.ListenTo(sensor, kAllHooks);
  StepTimes(400);
  ASSERT_FALSE(world_.IsAwake(box));

  world_.SetPose(box, {5, 0.3, 0});
  world_.Step(kStep);

  EXPECT_EQ(heard_.Story(), "b");
}

TEST_F(Contacts, PushASleepingBodyOutOfAStaticOneThatIsMovedOntoIt) {
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
