/// Circles and polygons, compared with Box2D's own ray casts.

#include "sight/visible_fixture.hpp"

#include <box2d/box2d.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <optional>
#include <random>
#include <vector>

#include "reference_walls.hpp"
#include "sight/beam_fan.hpp"
#include "sight/depth_buffer.hpp"

namespace flatland {
namespace {

// Box2D's own distance; nothing where a tiny change of the angle changes it much.
std::optional<double> AskBox2D(const b2Fixture& fixture, const Pose& lidar, double angle) {
  double distances[3];
  for (int i = 0; i < 3; ++i) {
    const Vec2 direction = Towards(lidar.yaw + angle + (i - 1) * 1e-3);
    b2RayCastInput ray;
    ray.p1 = {static_cast<float>(lidar.x), static_cast<float>(lidar.y)};
    ray.p2 = ray.p1 + b2Vec2{static_cast<float>(direction.x), static_cast<float>(direction.y)};
    ray.maxFraction = 100.0f;
    b2RayCastOutput hit;
    const b2Transform& place = fixture.GetBody()->GetTransform();
    const bool is_hit = fixture.GetShape()->RayCast(&hit, ray, place, 0);
    distances[i] = is_hit ? hit.fraction : kInfinity;
  }
  const auto [low, high] = std::minmax({distances[0], distances[1], distances[2]});
  if (low == kInfinity) return kInfinity;
  if (high - low > 0.02) return std::nullopt;
  return distances[1];
}

void ExpectAsBox2D(const b2Fixture& fixture, std::mt19937& random) {
  const Vec2 at = RandomPoint(random, {-3, -3}, {3, 3});
  const Pose lidar{at.x, at.y, std::uniform_real_distribution<double>(-3, 3)(random)};
  const BeamFan fan(-3.14, 0.02, 315);
  DepthBuffer buffer;
  buffer.Begin(fan, 100.0);
  const VisibleFixture visible(fixture, BoundingRadius(*fixture.GetShape()));
  BoundingCircles circles;
  circles.Add(visible.center, visible.bounding_radius);
  const std::vector<int> seen = buffer.FindVisible(circles, lidar);
  visible.DrawOn(buffer, at, Rotation(lidar.yaw));
  std::vector<float> ranges(fan.size());
  buffer.GetRanges(ranges.data());
  for (int beam = 0; beam < fan.size(); ++beam) {
    const double angle = -3.14 + beam * 0.02;
    const std::optional<double> expected = AskBox2D(fixture, lidar, angle);
    if (!expected) continue;
    const double distance = ranges[beam];
    if (*expected == kInfinity) {
      ASSERT_EQ(distance, kInfinity) << "towards " << angle;
      continue;
    }
    ASSERT_NEAR(distance, *expected, 1e-4) << "towards " << angle;
    ASSERT_EQ(seen.size(), 1u) << "what is hit must be looked at";
  }
}

class VisibleFixtureTest : public testing::Test {
 protected:
  b2Body& AddBody() {
    b2BodyDef definition;
    const Vec2 at = RandomPoint(random_, {-2, -2}, {2, 2});
    definition.position = {static_cast<float>(at.x), static_cast<float>(at.y)};
    definition.angle = std::uniform_real_distribution<float>(-3, 3)(random_);
    return *world_.CreateBody(&definition);
  }

  b2World world_{b2Vec2_zero};
  std::mt19937 random_{17};
};

TEST_F(VisibleFixtureTest, CastsAtPolygonsAsBox2DDoes) {
  for (int i = 0; i < 300; ++i) {
    std::vector<b2Vec2> corners(3 + i % 6);
    for (b2Vec2& corner : corners) {
      const Vec2 at = RandomPoint(random_, {-1, -1}, {1, 1});
      corner = {static_cast<float>(at.x), static_cast<float>(at.y)};
    }
    b2PolygonShape polygon;
    polygon.Set(corners.data(), static_cast<int32>(corners.size()));

    ASSERT_NO_FATAL_FAILURE(ExpectAsBox2D(*AddBody().CreateFixture(&polygon, 0.0f), random_))
        << "polygon " << i;
  }
}

TEST_F(VisibleFixtureTest, CastsAtCirclesAsBox2DDoes) {
  for (int i = 0; i < 300; ++i) {
    b2CircleShape circle;
    const Vec2 at = RandomPoint(random_, {-1, -1}, {1, 1});
    circle.m_p = {static_cast<float>(at.x), static_cast<float>(at.y)};
    circle.m_radius = std::uniform_real_distribution<float>(0.05f, 1.5f)(random_);

    ASSERT_NO_FATAL_FAILURE(ExpectAsBox2D(*AddBody().CreateFixture(&circle, 0.0f), random_))
        << "circle " << i;
  }
}

}  // namespace
}  // namespace flatland
