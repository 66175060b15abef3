/// Polygons, circles and bounding circles in a depth buffer; for walls see segment_tree_test.cpp.

#include "sight/depth_buffer.hpp"

#include <gtest/gtest.h>

#include <random>
#include <utility>
#include <vector>

#include "reference_walls.hpp"
#include "sight/beam_fan.hpp"
#include "test_numbers.hpp"

namespace flatland {
namespace {

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
