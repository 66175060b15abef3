/// Computes all beams of a scan together.
///
/// Need: hundreds of lidars with a thousand beams each, ten times a second and more, with the
/// results of exact geometry. A ray cast for each beam tests the same walls again and again.
///
/// Method: as in rasterisation, each wall is drawn once onto the beams between its two ends, and
/// each beam keeps the nearest wall. Beams are numbered by their rank, counter-clockwise:
///
///     ranks       7                                   1
///     wall 2  b-----------------------------------------a         0
///                    \                             /         /
///                       \     6  5  4  3  2     /       /
///     wall 1               \b===============a/     /
///                             \ \ \ | / / /   /
///                                \\\|/// /
///                                 lidar
///
///     rank           0    1    2    3    4    5    6    7
///     nearest wall   -    2    1    1    1    1    1    2
///
/// Data: the buffer holds one number for each beam, the inverse distance 1 / t. Ranks sort the
/// beams by direction (BeamFan), so the beams between two directions are one run of ranks, or two
/// runs if the backward direction, where ranks begin and end, is between them. Along a wall from a
/// to b, with b counter-clockwise of a as seen by the lidar, a beam in the direction of the unit
/// vector u ends at
///
///     1 / t = cross(u, b - a) / cross(a, b).
///
/// This is linear in u, so a wall costs each beam a few products and comparisons, no division, and
/// four beams are computed at a time (doubles.hpp). The larger 1 / t is the nearer wall. A beam
/// meets the wall if neither cross(a, u) nor cross(u, b) is negative; their sum is cross(u, b - a).
///
/// Wedges: which ranks a wall may cover is looked up by the directions of its two ends, their
/// wedge. It is a little too wide, to be safe from rounding errors; the signs above decide exactly.
/// All of this is in draw_walls.hpp.
///
/// Search: the walls of a layer are in a tree (SegmentTree). A box is skipped with all its walls if
/// every beam of its wedge already ends nearer than the box begins; so is a wall. The least of the
/// beams of a wedge is looked up in a table (Horizon), which is made a few times in a scan.
/// tree_search.hpp goes through the tree.
///
/// Order: first come the walls that the lidar saw last (SeenWalls). In an office these are 88, and
/// 23 more are drawn that came into view: 23 nodes and 40 leaves are looked at. Without them the
/// tree is searched in rings, from near to far. Bodies come last; those with a bounding circle out
/// of range or hidden are skipped.
///
/// Accuracy: all numbers are in double precision, and the results are the same on every processor.
/// With AVX2 four numbers are computed at a time, without it one or two.

#include "sight/depth_buffer.hpp"

#include <algorithm>
#include <array>
#include <limits>
#include <utility>

#include "sight/doubles.hpp"
#include "sight/draw_walls.hpp"
#include "sight/horizon.hpp"
#include "sight/tree_search.hpp"

namespace flatland {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
/// Relative tolerance of the range: a wall at exactly the range is seen.
constexpr double kRangeTolerance = 1e-12;
/// A reflecting wall or fixture that is farther than another one by up to this fraction is still
/// seen.
constexpr double kTieTolerance = 1e-9;

/// A shape at this distance, or nearer, counts as one that contains the lidar [m]: from a point of
/// its outline, rounding alone decides which of its sides are seen.
constexpr double kNearestShape = 1e-3;

/// Radii of the rings in which a tree is searched [m].
constexpr float kRings[] = {2.0f, 4.0f, 8.0f, std::numeric_limits<float>::infinity()};
/// Indices of a few walls.
constexpr auto kFewWalls = [] {
  std::array<uint32_t, SegmentTree::kFew> indices{};
  for (uint32_t i = 0; i < indices.size(); ++i) indices[i] = i;
  return indices;
}();
/// A lidar that is farther from where it was [m] has jumped, and sees other walls.
constexpr double kJump = 1.0;

FLATLAND_CLONES void DrawAll(const Segment* segments, const LidarView& view, const uint32_t* walls,
                             int count) {
  DrawIndexed(walls, count, segments, view);
}

FLATLAND_CLONES void Update(Horizon& horizon, const double* inverse) { horizon.Update(inverse); }

/// Draws the walls in the view of the tree that the horizon does not hide, except those that are
/// drawn already, and adds all of them to `seen`.
FLATLAND_CLONES void DrawRing(const SegmentTree& walls, const LidarView& view,
                              const Horizon& horizon, const TreeView& tree, const char* is_drawn,
                              SearchLists& lists, SeenWalls* seen) {
  const Hiding hiding{horizon, view.fan.before_buckets(), view.fan.size()};
  uint32_t waiting[kBlock + Lanes::kMost];
  int waits = 0;
  FindUnhidden(walls, tree, hiding, lists, [&](const int* visible, int found) FLATLAND_INLINED {
    for (int i = 0; i < found; ++i) {
      const auto wall = static_cast<uint32_t>(visible[i]);
      waiting[waits] = wall;
      waits += static_cast<int>(is_drawn[wall] == 0);
      if (seen->count < SeenWalls::kMost) seen->walls[seen->count] = wall;
      ++seen->count;
    }
    const int whole = waits / kBlock * kBlock;
    DrawIndexed(waiting, whole, walls.segments().data(), view);
    std::copy(waiting + whole, waiting + waits, waiting);
    waits -= whole;
  });
  DrawIndexed(waiting, waits, walls.segments().data(), view);
}

/// True if all beams of a run end nearer than a distance, by its square [m^2].
FLATLAND_INLINE bool EndNearer(const double* inverse, BeamFan::Run run, double square_distance) {
  for (int group = run.begin & -kGroup; group < run.end; group += kGroup) {
    const Doubles nearest = Load(inverse + group);
    const Mask reaches = nearest * nearest * square_distance < 1.0;
    if (!Any(reaches)) continue;
    for (int k = 0; k < kGroup; ++k) {
      if (reaches[k] != 0 && group + k >= run.begin && group + k < run.end) return false;
    }
  }
  return true;
}

/// Appends the indices of the circles in range that are not hidden.
FLATLAND_CLONES void FindVisibleIn(const BoundingCircles& circles, const LidarView& view,
                                   double range, std::vector<int>* visible) {
  const Doubles cos = Fill(view.rotation.cos), sin = Fill(view.rotation.sin);
  for (int group = 0; group < circles.count; group += kGroup) {
    const Doubles world_x = Load(&circles.x[group]) - view.origin.x;
    const Doubles world_y = Load(&circles.y[group]) - view.origin.y;
    const Doubles radius = Load(&circles.radius[group]);
    const Doubles square_distance = world_x * world_x + world_y * world_y;
    const Doubles nearest = Sqrt(square_distance) - radius;
    double distances[kGroup];
    Store(nearest, distances);
    if (!Any(nearest <= range)) continue;
    // Directions of the tangents to the right and to the left of each circle, of any length.
    const Doubles x = cos * world_x + sin * world_y;
    const Doubles y = cos * world_y - sin * world_x;
    const Doubles along = Sqrt(square_distance - radius * radius);
    double from[kGroup], to[kGroup];
    Store(WidenRight(DiamondAngles(along * x + radius * y, along * y - radius * x)), from);
    Store(WidenLeft(DiamondAngles(along * x - radius * y, along * y + radius * x)), to);
    for (int k = 0; k < kGroup && group + k < circles.count; ++k) {
      if (distances[k] > range) continue;
      const auto is_hidden = [&] {
        const auto runs = view.fan.BeamsIn({from[k], to[k]});
        const double square_distance = distances[k] * distances[k];
        return EndNearer(view.inverse, runs[0], square_distance) &&
               EndNearer(view.inverse, runs[1], square_distance);
      };
      const bool contains_lidar = !(distances[k] > 0.0);  // or is at NaN
      if (contains_lidar || !is_hidden()) {
        visible->push_back(group + k);
      }
    }
  }
}

FLATLAND_CLONES void DrawCircleOn(const BeamFan& fan, double* inverse, Vec2 center, double radius,
                                  double square_distance) {
  const double square_radius = radius * radius;
  const double to_touch = std::sqrt(square_distance - square_radius);
  const Vec2 right{to_touch * center.x + radius * center.y,
                   to_touch * center.y - radius * center.x};
  const Vec2 left{to_touch * center.x - radius * center.y, to_touch * center.y + radius * center.x};
  // From the distance t of the nearer intersection, t = along - sqrt(r^2 - across^2), and from
  // along^2 + across^2 = |c|^2:  1 / t = (along + sqrt(r^2 - across^2)) / (|c|^2 - r^2).
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

/// True if the side of a polygon from a to b is too near to the lidar to be seen.
bool IsTooNear(Vec2 a, Vec2 b) {
  constexpr double kSquare = kNearestShape * kNearestShape;
  const Vec2 side = b - a;
  const double square_length = Dot(side, side), cross = Cross(a, b);
  if (cross * cross > kSquare * square_length) return false;  // its line is not near
  const double along = std::clamp(-Dot(a, side) / square_length, 0.0, 1.0);
  const Vec2 nearest = a + along * side;
  return Dot(nearest, nearest) <= kSquare;
}

FLATLAND_CLONES void DrawSide(const BeamFan& fan, double* inverse, Vec2 a, Vec2 b, double cross) {
  for (const BeamFan::Run& run : fan.BeamsBetween(a, b)) {
    if (run.begin < run.end) DrawOn(fan, inverse, run, a, b, 1.0 / cross);
  }
}

/// Sets `count` values, a multiple of kGroup.
FLATLAND_CLONES void FillAll(double* values, int count, double value) {
  for (int i = 0; i < count; i += kGroup) Store(Fill(value), values + i);
}

/// Distances from the greater of two inverse distances each.
FLATLAND_CLONES void Invert(const double* inverse, const double* other, int count,
                            double min_inverse, float* ranges) {
  int i = 0;
  for (; i + kGroup <= count; i += kGroup) {
    const Doubles one = Load(inverse + i), two = Load(other + i);
    const Doubles nearest = one > two ? one : two;
    const Doubles distances = nearest > min_inverse ? 1.0 / nearest : Fill(kInfinity);
    Store(ToFloats(distances), ranges + i);
  }
  for (; i < count; ++i) {
    const double nearest = std::max(inverse[i], other[i]);
    ranges[i] = static_cast<float>(nearest > min_inverse ? 1.0 / nearest : kInfinity);
  }
}

}  // namespace

void BoundingCircles::Add(Vec2 center, double circle_radius) {
  if (count == static_cast<int>(x.size())) {
    for (std::vector<double>* values : {&x, &y, &radius}) values->resize(count + kGroup, 0.0);
  }
  x[count] = center.x;
  y[count] = center.y;
  radius[count] = circle_radius;
  ++count;
}

DepthBuffer::DepthBuffer()
    : horizon_(std::make_unique<Horizon>()), lists_(std::make_unique<SearchLists>()) {}
DepthBuffer::~DepthBuffer() = default;

LidarView DepthBuffer::ViewFrom(const Pose& lidar) {
  return {*fan_, inverse_.data(), {lidar.x, lidar.y}, Rotation(lidar.yaw)};
}

void DepthBuffer::Begin(const BeamFan& fan, double range) {
  fan_ = &fan;
  range_ = range;
  min_inverse_ = (1.0 - kRangeTolerance) / range;
  inverse_.resize(fan.padded_size());
  FillAll(inverse_.data(), fan.padded_size(), min_inverse_);
  non_reflecting_.clear();
}

void DepthBuffer::Draw(const SegmentTree& walls, const Pose& lidar, SeenWalls* last) {
  const size_t count = walls.segment_count();
  if (count <= kFewWalls.size()) {
    Draw(walls, {kFewWalls.data(), count}, lidar);
    return;
  }
  if (is_drawn_.size() < count) is_drawn_.resize(count, 0);
  lists_->MakeRoomFor(walls);
  const LidarView view = ViewFrom(lidar);
  SeenWalls seen;
  seen.place = view.origin;
  horizon_->Begin(fan_->size());
  const auto draw_ring = [&](float from, float to) {
    Update(*horizon_, inverse_.data());
    const TreeView tree(walls, view.origin, view.rotation, fan_->buckets_per_unit(), from, to);
    DrawRing(walls, view, *horizon_, tree, is_drawn_.data(), *lists_, &seen);
  };
  const auto is_known = [&] {
    if (last == nullptr || last->count == 0) return false;
    const Vec2 way = view.origin - last->place;
    return Dot(way, way) <= kJump * kJump &&
           std::all_of(last->walls, last->walls + last->count,
                       [count](uint32_t wall) { return wall < count; });
  };
  if (is_known()) {
    DrawAll(walls.segments().data(), view, last->walls, last->count);
    for (int i = 0; i < last->count; ++i) is_drawn_[last->walls[i]] = 1;
    draw_ring(0.0f, std::numeric_limits<float>::infinity());
    for (int i = 0; i < last->count; ++i) is_drawn_[last->walls[i]] = 0;
  } else {
    float from = 0.0f;
    for (const float to : kRings) {
      draw_ring(from, to);
      from = to;
    }
  }
  if (last == nullptr) return;
  last->place = seen.place;
  last->count = std::min(seen.count, SeenWalls::kMost);
  std::copy_n(seen.walls, last->count, last->walls);
}

void DepthBuffer::Draw(const SegmentTree& walls, WallList only, const Pose& lidar) {
  DrawAll(walls.segments().data(), ViewFrom(lidar), only.indices, static_cast<int>(only.count));
}

void DepthBuffer::DrawCircle(Vec2 center, double radius) {
  const double square_distance = Dot(center, center);
  const double nearest = radius + kNearestShape;
  const bool is_outside = square_distance > nearest * nearest;
  if (is_outside) DrawCircleOn(*fan_, inverse_.data(), center, radius, square_distance);
}

void DepthBuffer::DrawPolygon(const Vec2* corners, int count) {
  for (int i = 0; i < count; ++i) {
    if (IsTooNear(corners[i], corners[i + 1 < count ? i + 1 : 0])) return;
  }
  // The sides that face a lidar outside run clockwise around it. From within no side does.
  for (int i = 0; i < count; ++i) {
    const Vec2 corner = corners[i];
    const Vec2 next = corners[i + 1 < count ? i + 1 : 0];
    const double cross = Cross(next, corner);
    const bool faces_lidar = cross > kEdgeOn * ManhattanNorm(next) * ManhattanNorm(corner);
    if (faces_lidar) DrawSide(*fan_, inverse_.data(), next, corner, cross);
  }
}

const std::vector<int>& DepthBuffer::FindVisible(const BoundingCircles& circles,
                                                 const Pose& lidar) {
  visible_.clear();
  FindVisibleIn(circles, ViewFrom(lidar), range_, &visible_);
  return visible_;
}

void DepthBuffer::BeginReflecting() {
  non_reflecting_ = inverse_;
  for (double& inverse : inverse_) inverse *= 1.0 - kTieTolerance;
}

void DepthBuffer::GetRanges(float* ranges) const {
  const double* other = non_reflecting_.empty() ? inverse_.data() : non_reflecting_.data();
  if (fan_->is_sorted()) {
    Invert(inverse_.data(), other, fan_->size(), min_inverse_, ranges);
    return;
  }
  for (int rank = 0; rank < fan_->size(); ++rank) {
    Invert(&inverse_[rank], &other[rank], 1, min_inverse_, &ranges[fan_->beams()[rank]]);
  }
}

void DepthBuffer::GetIntensities(float* intensities) const {
  std::fill_n(intensities, fan_->size(), 0.0f);
  for (int rank = 0; rank < fan_->size() && !non_reflecting_.empty(); ++rank) {
    const bool is_in_range = std::max(inverse_[rank], non_reflecting_[rank]) > min_inverse_;
    const bool reflects =
        is_in_range && inverse_[rank] > non_reflecting_[rank] * (1.0 - kTieTolerance);
    intensities[fan_->beams()[rank]] = reflects ? 255.0f : 0.0f;
  }
}

}  // namespace flatland
