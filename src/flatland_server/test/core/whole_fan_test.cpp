/// Scans with many beams, compared beam by beam with a test of every wall.

#include <gtest/gtest.h>

#include <cmath>
#include <ostream>
#include <random>
#include <vector>

#include "reference_walls.hpp"
#include "sight/beam_fan.hpp"
#include "sight/depth_buffer.hpp"
#include "sight/segment_tree.hpp"

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

}  // namespace
}  // namespace flatland
