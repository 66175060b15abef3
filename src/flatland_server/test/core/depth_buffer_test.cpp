/// Walls, polygons and circles in a depth buffer of many beams, compared with a test of every wall.

#include "sight/depth_buffer.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <ostream>
#include <random>
#include <utility>
#include <vector>

#include "reference_walls.hpp"
#include "sight/beam_fan.hpp"
#include "sight/segment_tree.hpp"
#include "test_numbers.hpp"

namespace flatland {
namespace {

// Walls are drawn onto several beams at a time, and skipped if they are hidden.
void ExpectEachBeamAsIfAlone(const std::vector<Segment>& walls, const BeamFan& fan, Vec2 low,
                             Vec2 high) {
  const SegmentTree tree(walls);
  std::mt19937 random(23);
  DepthBuffer buffer;
  std::vector<float> ranges(fan.size());
  for (int i = 0; i < 30; ++i) {
    const Vec2 at = RandomPoint(random, low, high);
    const double yaw = std::uniform_real_distribution<double>(-4, 4)(random);
    buffer.Begin(fan, 12.0);
    buffer.Draw(tree, {at.x, at.y, yaw});
    buffer.GetRanges(ranges.data());
    for (int beam = 0; beam < fan.size(); ++beam) {
      const Vec2 direction = Rotation(yaw).Apply(fan.direction(beam));
      const double least = TryEveryWall(walls, at, direction, 1e-8);
      const double most = TryEveryWall(walls, at, direction, -1e-8);
      if (ranges[beam] == kInfinity) {
        ASSERT_GT(most, 12.0 - 1e-5) << "beam " << beam << " of scan " << i;
      } else {
        ASSERT_GT(ranges[beam], least - 1e-5) << "beam " << beam << " of scan " << i;
        ASSERT_LT(ranges[beam], most + 1e-5) << "beam " << beam << " of scan " << i;
      }
    }
  }
}

struct NamedFan {
  const char* name;
  BeamFan fan;

  friend void PrintTo(const NamedFan& named, std::ostream* out) { *out << named.name; }
};

class WholeFan : public testing::TestWithParam<NamedFan> {};

TEST_P(WholeFan, SeesRandomWalls) {
  ExpectEachBeamAsIfAlone(RandomWalls(400, 2.0), GetParam().fan, {-1, -1}, {21, 11});
}

TEST_P(WholeFan, SeesThePixelsOfAMap) {
  ExpectEachBeamAsIfAlone(PixelWalls(40, 25), GetParam().fan, {-2, -2}, {44, 29});
}

TEST_P(WholeFan, SeesFromTheCornersOfPixels) {
  const std::vector<Segment> walls = PixelWalls(12, 9);
  const SegmentTree tree(walls);
  DepthBuffer buffer;
  std::vector<float> ranges(GetParam().fan.size());
  for (double x = 0; x < 14; ++x) {
    for (double y = 0; y < 11; ++y) {
      const bool touches = TryEveryWall(walls, {x, y}, {0.6, 0.8}, 0.0) == 0.0;
      buffer.Begin(GetParam().fan, 50.0);
      buffer.Draw(tree, {x, y, 0.1});
      buffer.GetRanges(ranges.data());
      for (float range : ranges) ASSERT_EQ(range == 0.0f, touches) << x << ", " << y;
    }
  }
}

INSTANTIATE_TEST_SUITE_P(
    Fans, WholeFan,
    testing::Values(NamedFan{"three_quarters", {-0.75 * M_PI, 1.5 * M_PI / 400, 401}},
                    NamedFan{"clockwise", {0.75 * M_PI, -1.5 * M_PI / 400, 401}},
                    NamedFan{"full_rotation", {0.0, 2.0 * M_PI / 360, 360}},
                    NamedFan{"two_rotations", {-M_PI, 4.0 * M_PI / 300, 301}},
                    NamedFan{"coarse", {0.3, 1.1, 7}}, NamedFan{"single", {2.0, 0.0, 1}}),
    [](const testing::TestParamInfo<NamedFan>& info) { return info.param.name; });

TEST(DepthBuffer, SeesNoPolygonNearerThanItIsAlongItsSide) {
  std::mt19937 random(29);
  DepthBuffer buffer;
  for (int i = 0; i < 3000; ++i) {
    const Rotation rotation(std::uniform_real_distribution<double>(-3, 3)(random));
    const double near = 0.05 * (1 + random() % 100), far = near + 0.05 * (1 + random() % 100);
    const double side = i % 2 == 0 ? 1.0 : -1.0;
    Vec2 corners[] = {{near, 0}, {far, 0}, {0.5 * (near + far), side}};
    if (side < 0.0) std::swap(corners[0], corners[1]);
    for (Vec2& corner : corners) corner = rotation.Apply(corner);
    const BeamFan fan(std::vector<Vec2>{rotation.Apply({1, 0})});
    float range;
    buffer.Begin(fan, kFar);
    buffer.DrawPolygon(corners, 3);
    buffer.GetRanges(&range);
    ASSERT_GT(range, 0.999 * near) << "polygon " << i;
  }
}

// Box2D computes NaN for a body that is much too light for the force on it.
TEST(DepthBuffer, SeesNothingAtNaN) {
  const BeamFan fan(-3.0, 0.01, 601);
  const Vec2 corners[] = {{1, 0}, {kNaN, kNaN}, {kNaN, kNaN}};
  BoundingCircles circles;
  circles.Add({kNaN, kNaN}, 1.0);
  circles.Add({3, 0}, 1.0);
  DepthBuffer buffer;
  buffer.Begin(fan, 10.0);
  buffer.FindVisible(circles, {});
  buffer.DrawCircle({kNaN, kNaN}, 1.0);
  buffer.DrawPolygon(corners, 3);

  std::vector<float> ranges(fan.size());
  buffer.GetRanges(ranges.data());
  for (float range : ranges) EXPECT_EQ(range, kInfinity);
}

}  // namespace
}  // namespace flatland
