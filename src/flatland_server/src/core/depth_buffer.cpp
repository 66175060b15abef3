#include "flatland_server/depth_buffer.hpp"

#include <algorithm>
#include <cstring>
#include <limits>

// Compiled twice, and the right one taken at run time: the default build runs on any processor.
#if defined(__x86_64__) && defined(__GNUC__) && !defined(__clang__)
#define FLATLAND_CLONES __attribute__((target_clones("avx2", "default")))
#else
#define FLATLAND_CLONES
#endif
// What is called from there belongs to both.
#define FLATLAND_INLINE __attribute__((always_inline)) inline

namespace flatland {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
/// How far past its ends a wall still stops a beam, as a fraction of its length: two walls that
/// share a corner leave no gap between them.
constexpr double kEndTolerance = 1e-9;
/// What is at the range itself is seen; so this much more than the range counts as within it.
constexpr double kRangeTolerance = 1e-12;
/// How much farther something that reflects may be than what does not, and still be seen.
constexpr double kTie = 1e-9;

constexpr int kGroup = BeamFan::kGroup;
constexpr int kLeafSize = SegmentTree::kLeafSize;

/// A few numbers at a time; the compiler makes of it what the processor has. Comparisons give
/// masks.
using Doubles = double __attribute__((vector_size(kGroup * sizeof(double))));
using Mask = long long __attribute__((vector_size(kGroup * sizeof(long long))));
static_assert(kGroup == 4, "Fill names its numbers");

FLATLAND_INLINE Doubles Fill(double value) { return Doubles{value, value, value, value}; }

FLATLAND_INLINE Doubles Load(const double* values) {
  Doubles loaded;
  std::memcpy(&loaded, values, sizeof(loaded));
  return loaded;
}

FLATLAND_INLINE void Store(const Doubles& stored, double* values) {
  std::memcpy(values, &stored, sizeof(stored));
}

FLATLAND_INLINE Doubles DiamondAngles(const Doubles& x, const Doubles& y) {
  const Doubles slant = y / ((x < 0.0 ? -x : x) + (y < 0.0 ? -y : y));
  return x >= 0.0 ? slant : (y >= 0.0 ? 2.0 - slant : -2.0 - slant);
}

/// The buffer and where it is seen from, in registers.
struct View {
  const BeamFan& fan;
  double* inverse;
  Vec2 origin;
  Rotation rotation;
};

/// Whether all beams of a run end at least as near as this.
FLATLAND_INLINE bool EndBefore(const double* inverse, BeamFan::Run run, double least) {
  const Doubles limit = Fill(least);
  for (int group = run.begin / kGroup * kGroup; group < run.end; group += kGroup) {
    const Mask reaches = Load(inverse + group) < limit;
    if ((reaches[0] | reaches[1] | reaches[2] | reaches[3]) == 0) continue;
    for (int k = 0; k < kGroup; ++k) {
      if (reaches[k] != 0 && group + k >= run.begin && group + k < run.end) return false;
    }
  }
  return true;
}

FLATLAND_INLINE bool IsHiddenBetween(const BeamFan& fan, const double* inverse, Vec2 from, Vec2 to,
                                     double distance) {
  const double least = 1.0 / distance;
  for (const BeamFan::Run& run : fan.BeamsBetween(from, to)) {
    if (!EndBefore(inverse, run, least)) return false;
  }
  return true;
}

/// Draws the wall from a to b, which is counter-clockwise of a, on a run of beams.
FLATLAND_INLINE void DrawOn(const BeamFan& fan, double* inverse, BeamFan::Run run, Vec2 a, Vec2 b,
                            double inverse_cross) {
  const Doubles ax = Fill(a.x), ay = Fill(a.y), bx = Fill(b.x), by = Fill(b.y);
  const Doubles scale = Fill(inverse_cross);
  for (int group = run.begin / kGroup * kGroup; group < run.end; group += kGroup) {
    const Doubles x = Load(fan.xs() + group);
    const Doubles y = Load(fan.ys() + group);
    const Doubles nearest = Load(inverse + group);
    const Doubles past_a = ax * y - ay * x;
    const Doubles before_b = x * by - y * bx;
    const Doubles across = past_a + before_b;  // cross(u, b - a)
    const Doubles tolerance = -kEndTolerance * across;
    const Doubles drawn = across * scale;
    const Mask is_nearest = (past_a >= tolerance) & (before_b >= tolerance) & (drawn > nearest);
    Store(is_nearest ? drawn : nearest, inverse + group);
  }
}

/// The lidar stands on the wall itself: every beam but the two along it ends at once.
void DrawUnderfoot(const BeamFan& fan, double* inverse, Vec2 along) {
  for (int rank = 0; rank < fan.size(); ++rank) {
    if (Cross({fan.xs()[rank], fan.ys()[rank]}, along) != 0.0) inverse[rank] = kInfinity;
  }
}

FLATLAND_INLINE void DrawLeaf(const SegmentTree::Leaf& leaf, const View& view) {
  double ax[kLeafSize], ay[kLeafSize], bx[kLeafSize], by[kLeafSize];
  double crosses[kLeafSize], inverse_crosses[kLeafSize], from[kLeafSize], to[kLeafSize];
  const Doubles cos = Fill(view.rotation.cos), sin = Fill(view.rotation.sin);
  for (int lane = 0; lane < kLeafSize; lane += kGroup) {
    const Doubles world_ax = Load(leaf.ax + lane) - view.origin.x;
    const Doubles world_ay = Load(leaf.ay + lane) - view.origin.y;
    const Doubles world_bx = Load(leaf.bx + lane) - view.origin.x;
    const Doubles world_by = Load(leaf.by + lane) - view.origin.y;
    const Doubles first_x = cos * world_ax + sin * world_ay;
    const Doubles first_y = cos * world_ay - sin * world_ax;
    const Doubles second_x = cos * world_bx + sin * world_by;
    const Doubles second_y = cos * world_by - sin * world_bx;
    const Doubles cross = first_x * second_y - first_y * second_x;
    const Mask swap = cross < 0.0;
    const Doubles right_x = swap ? second_x : first_x, right_y = swap ? second_y : first_y;
    const Doubles left_x = swap ? first_x : second_x, left_y = swap ? first_y : second_y;
    const Doubles size = swap ? -cross : cross;
    Store(right_x, ax + lane);
    Store(right_y, ay + lane);
    Store(left_x, bx + lane);
    Store(left_y, by + lane);
    Store(size, crosses + lane);
    Store(1.0 / size, inverse_crosses + lane);
    Store(DiamondAngles(right_x, right_y), from + lane);
    Store(DiamondAngles(left_x, left_y), to + lane);
  }
  for (int lane = 0; lane < kLeafSize; ++lane) {
    const Vec2 a{ax[lane], ay[lane]};
    const Vec2 b{bx[lane], by[lane]};
    if (crosses[lane] > 0.0) {
      for (const BeamFan::Run& run : view.fan.BeamsBetween(from[lane], to[lane])) {
        DrawOn(view.fan, view.inverse, run, a, b, inverse_crosses[lane]);
      }
    } else if (crosses[lane] == 0.0 && Dot(a, b) <= 0.0) {
      DrawUnderfoot(view.fan, view.inverse, b - a);
    }
  }
}

/// Square of the distance from a point to the nearest of a box.
FLATLAND_INLINE double SquareDistance(Vec2 point, const Box& box) {
  const double x = std::max(std::max(box.low.x - point.x, point.x - box.high.x), 0.0);
  const double y = std::max(std::max(box.low.y - point.y, point.y - box.high.y), 0.0);
  return x * x + y * y;
}

/// The corners of a box that are farthest to the right and to the left, as seen from outside.
struct Silhouette {
  bool right_is_high_x, right_is_high_y, left_is_high_x, left_is_high_y;
};
/// By where one looks from: below, beside or above it, and there left of, beside or right of it.
constexpr Silhouette kSilhouettes[3][3] = {
    {{true, false, false, true}, {true, false, false, false}, {true, true, false, false}},
    {{false, false, false, true}, {false, false, false, false}, {true, true, true, false}},
    {{false, false, true, true}, {false, true, true, true}, {false, true, true, false}},
};

FLATLAND_INLINE bool IsHidden(const Box& box, double square_distance, const View& view) {
  if (!(square_distance > 0.0)) return false;  // the lidar is within
  const auto side = [](double place, double low, double high) {
    return place < low ? 0 : (place > high ? 2 : 1);
  };
  const Silhouette& seen = kSilhouettes[side(view.origin.y, box.low.y, box.high.y)]
                                       [side(view.origin.x, box.low.x, box.high.x)];
  const Vec2 right{seen.right_is_high_x ? box.high.x : box.low.x,
                   seen.right_is_high_y ? box.high.y : box.low.y};
  const Vec2 left{seen.left_is_high_x ? box.high.x : box.low.x,
                  seen.left_is_high_y ? box.high.y : box.low.y};
  return IsHiddenBetween(view.fan, view.inverse, view.rotation.ApplyInverse(right - view.origin),
                         view.rotation.ApplyInverse(left - view.origin),
                         std::sqrt(square_distance));
}

/// Which of a node's children to draw first: the nearer one, and of those that the lidar is in, the
/// one whose middle is nearer.
FLATLAND_INLINE bool IsSecondNearer(const SegmentTree::Node& node, const double* square_distances,
                                    Vec2 origin) {
  if (square_distances[0] != square_distances[1]) return square_distances[1] < square_distances[0];
  const auto to_middle = [&](const Box& box) {
    const Vec2 way = 0.5 * (box.low + box.high) - origin;
    return Dot(way, way);
  };
  return to_middle(node.children[1].box) < to_middle(node.children[0].box);
}

FLATLAND_CLONES void DrawTree(const SegmentTree& walls, const View& view) {
  const SegmentTree::Child* waiting[SegmentTree::kMostDepth];
  int count = 0;
  const SegmentTree::Child* child = &walls.root();
  if (IsHidden(child->box, SquareDistance(view.origin, child->box), view)) return;
  while (true) {
    const SegmentTree::Child* next = nullptr;
    if (child->is_leaf()) {
      DrawLeaf(walls.leaf(*child), view);
    } else {
      const SegmentTree::Node& node = walls.node(*child);
      double square_distances[2];
      bool are_hidden[2];
      for (int k = 0; k < 2; ++k) {
        square_distances[k] = SquareDistance(view.origin, node.children[k].box);
        are_hidden[k] = IsHidden(node.children[k].box, square_distances[k], view);
      }
      if (!are_hidden[0] && !are_hidden[1]) {
        const int first = IsSecondNearer(node, square_distances, view.origin) ? 1 : 0;
        next = &node.children[first];
        waiting[count++] = &node.children[1 - first];
      } else if (!are_hidden[0]) {
        next = &node.children[0];
      } else if (!are_hidden[1]) {
        next = &node.children[1];
      }
    }
    // What has waited may have been hidden meanwhile.
    while (next == nullptr && count > 0) {
      next = waiting[--count];
      if (IsHidden(next->box, SquareDistance(view.origin, next->box), view)) next = nullptr;
    }
    if (next == nullptr) return;
    child = next;
  }
}

/// The two tangents from the lidar to a circle that it is outside of, as vectors of no certain
/// length: to its right and to its left.
FLATLAND_INLINE void FindTangents(Vec2 center, double radius, double square_distance, Vec2* right,
                                  Vec2* left) {
  const double along = std::sqrt(square_distance - radius * radius);
  *right = {along * center.x + radius * center.y, along * center.y - radius * center.x};
  *left = {along * center.x - radius * center.y, along * center.y + radius * center.x};
}

FLATLAND_CLONES void DrawCircleOn(const BeamFan& fan, double* inverse, Vec2 center, double radius,
                                  double square_distance) {
  Vec2 right, left;
  FindTangents(center, radius, square_distance, &right, &left);
  // From the distance t of the nearer intersection, t = along - sqrt(r^2 - across^2), and from
  // along^2 + across^2 = |c|^2:  1 / t = (along + sqrt(r^2 - across^2)) / (|c|^2 - r^2).
  const double square_radius = radius * radius;
  const double scale = 1.0 / (square_distance - square_radius);
  for (const BeamFan::Run& run : fan.BeamsBetween(right, left)) {
    for (int rank = run.begin; rank < run.end; ++rank) {
      const Vec2 direction{fan.xs()[rank], fan.ys()[rank]};
      const double along = Dot(center, direction);
      const double across = Cross(center, direction);
      const double square_half_chord = square_radius - across * across;
      const double drawn = (along + std::sqrt(std::max(square_half_chord, 0.0))) * scale;
      const bool is_hit = square_half_chord >= 0.0 && along > 0.0;
      inverse[rank] = is_hit && drawn > inverse[rank] ? drawn : inverse[rank];
    }
  }
}

FLATLAND_CLONES void DrawSide(const BeamFan& fan, double* inverse, Vec2 a, Vec2 b, double cross) {
  for (const BeamFan::Run& run : fan.BeamsBetween(a, b)) {
    DrawOn(fan, inverse, run, a, b, 1.0 / cross);
  }
}

}  // namespace

void DepthBuffer::Begin(const BeamFan& fan, double range) {
  fan_ = &fan;
  range_ = range;
  inverse_.assign(fan.padded_size(), (1.0 - kRangeTolerance) / range);
  dull_.clear();
}

void DepthBuffer::Draw(const SegmentTree& walls, const Pose& lidar) {
  if (walls.segment_count() == 0) return;
  DrawTree(walls, {*fan_, inverse_.data(), {lidar.x, lidar.y}, Rotation(lidar.yaw)});
}

void DepthBuffer::DrawCircle(Vec2 center, double radius) {
  const double square_distance = Dot(center, center);
  if (square_distance <= radius * radius) return;
  DrawCircleOn(*fan_, inverse_.data(), center, radius, square_distance);
}

void DepthBuffer::DrawPolygon(const Vec2* corners, int count) {
  // Seen from outside, the sides that face the lidar run clockwise around it; from within, none.
  for (int i = 0; i < count; ++i) {
    const Vec2 corner = corners[i];
    const Vec2 next = corners[i + 1 < count ? i + 1 : 0];
    const double cross = Cross(next, corner);
    if (cross > 0.0) DrawSide(*fan_, inverse_.data(), next, corner, cross);
  }
}

bool DepthBuffer::IsHidden(Vec2 center, double radius) const {
  const double square_distance = Dot(center, center);
  const double nearest = std::sqrt(square_distance) - radius;
  if (!(nearest > 0.0)) return false;
  if (nearest > range_) return true;
  Vec2 right, left;
  FindTangents(center, radius, square_distance, &right, &left);
  return IsHiddenBetween(*fan_, inverse_.data(), right, left, nearest);
}

void DepthBuffer::BeginReflecting() {
  dull_ = inverse_;
  for (double& inverse : inverse_) inverse *= 1.0 - kTie;
}

void DepthBuffer::GetRanges(float* ranges) const {
  const double beyond = (1.0 - kRangeTolerance) / range_;
  for (int rank = 0; rank < fan_->size(); ++rank) {
    const double inverse = dull_.empty() ? inverse_[rank] : std::max(inverse_[rank], dull_[rank]);
    ranges[fan_->beams()[rank]] = static_cast<float>(inverse > beyond ? 1.0 / inverse : kInfinity);
  }
}

void DepthBuffer::GetIntensities(float* intensities) const {
  for (int rank = 0; rank < fan_->size(); ++rank) {
    const bool reflects = !dull_.empty() && inverse_[rank] > dull_[rank] * (1.0 - kTie);
    intensities[fan_->beams()[rank]] = reflects ? 255.0f : 0.0f;
  }
}

}  // namespace flatland
