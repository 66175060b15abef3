/// Points and normals of contacts at any angle; impulses of friction.

#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "test_contact.hpp"
#include "world/contact.hpp"
#include "world/world.hpp"

namespace flatland {
namespace {

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
