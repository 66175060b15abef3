#include "flatland_server/depth_buffer.hpp"

#include <algorithm>
#include <array>
#include <limits>

#include "doubles.hpp"

namespace flatland {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
/// How far past its ends a wall still stops a beam, as a fraction of its length: two walls that
/// share a corner leave no gap between them.
constexpr double kEndTolerance = 1e-9;
/// A wall whose ends are seen less than this angle [rad] apart, or less than this from opposite, is
/// seen edge-on: its distance would be a quotient of two roundings.
constexpr double kEdgeOn = 1e-14;
/// What is at the range itself is seen; so this much more than the range counts as within it.
constexpr double kRangeTolerance = 1e-12;
/// How much farther something that reflects may be than what does not, and still be seen.
constexpr double kTie = 1e-9;

constexpr int kLeafSize = SegmentTree::kLeafSize;

/// The buffer and where it is seen from, in registers.
struct View {
  const BeamFan& fan;
  double* inverse;
  Vec2 origin;
  Rotation rotation;
};

/// The beams towards something, and how near the nearest of it is.
struct Outlook {
  std::array<BeamFan::Run, 2> runs;
  double square_distance;  // 0 for what is around the lidar
};

/// Whether all beams of a run end before something at a distance begins.
FLATLAND_INLINE bool EndBefore(const double* inverse, BeamFan::Run run, double square_distance) {
  for (int group = run.begin / kGroup * kGroup; group < run.end; group += kGroup) {
    const Doubles nearest = Load(inverse + group);
    const Mask reaches = nearest * nearest * square_distance < 1.0;
    if (!Any(reaches)) continue;
    for (int k = 0; k < kGroup; ++k) {
      if (reaches[k] != 0 && group + k >= run.begin && group + k < run.end) return false;
    }
  }
  return true;
}

FLATLAND_INLINE bool IsHidden(const double* inverse, const Outlook& outlook) {
  if (!(outlook.square_distance > 0.0)) return false;
  return EndBefore(inverse, outlook.runs[0], outlook.square_distance) &&
         EndBefore(inverse, outlook.runs[1], outlook.square_distance);
}

/// Moves diamond angles apart by the slack of BeamFan, and back to where they are defined.
FLATLAND_INLINE Doubles WidenedRight(const Doubles& diamond_angles) {
  const Doubles moved = diamond_angles - BeamFan::kSlack;
  return moved < -2.0 ? moved + 4.0 : moved;
}
FLATLAND_INLINE Doubles WidenedLeft(const Doubles& diamond_angles) {
  const Doubles moved = diamond_angles + BeamFan::kSlack;
  return moved > 2.0 ? moved - 4.0 : moved;
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
    const double across = Cross({fan.xs()[rank], fan.ys()[rank]}, along);
    if (std::abs(across) > kEdgeOn * Size(along)) inverse[rank] = kInfinity;
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
    const Mask is_edge_on = size <= kEdgeOn * Sizes(right_x, right_y) * Sizes(left_x, left_y);
    Store(right_x, ax + lane);
    Store(right_y, ay + lane);
    Store(left_x, bx + lane);
    Store(left_y, by + lane);
    Store(is_edge_on ? Fill(0.0) : size, crosses + lane);
    Store(1.0 / size, inverse_crosses + lane);
    Store(WidenedRight(DiamondAngles(right_x, right_y)), from + lane);
    Store(WidenedLeft(DiamondAngles(left_x, left_y)), to + lane);
  }
  for (int lane = 0; lane < kLeafSize; ++lane) {
    const Vec2 a{ax[lane], ay[lane]};
    const Vec2 b{bx[lane], by[lane]};
    if (crosses[lane] > 0.0) {
      const std::array<BeamFan::Run, 2> runs = view.fan.BeamsIn({from[lane], to[lane]});
      DrawOn(view.fan, view.inverse, runs[0], a, b, inverse_crosses[lane]);
      if (from[lane] > to[lane]) {
        DrawOn(view.fan, view.inverse, runs[1], a, b, inverse_crosses[lane]);
      }
    } else if (crosses[lane] == 0.0 && Dot(a, b) <= 0.0) {
      DrawUnderfoot(view.fan, view.inverse, b - a);
    }
  }
}

/// The corners of a box that are farthest to the right and to the left, as seen from outside: the
/// places of their coordinates in low x, low y, high x, high y.
struct Silhouette {
  int right_x, right_y, left_x, left_y;
};
/// By where one looks from: below, beside or above it, and there left of, beside or right of it.
constexpr Silhouette kSilhouettes[3][3] = {
    {{2, 1, 0, 3}, {2, 1, 0, 1}, {2, 3, 0, 1}},
    {{0, 1, 0, 3}, {0, 1, 0, 1}, {2, 3, 2, 1}},
    {{0, 1, 2, 3}, {0, 3, 2, 3}, {0, 3, 2, 1}},
};

/// What a node's two boxes look like.
FLATLAND_INLINE void LookAt(const SegmentTree::Node& node, const View& view, Outlook* outlooks) {
  const auto side = [](double place, double low, double high) {
    return (place >= low) + (place > high);
  };
  double xs[kGroup], ys[kGroup];  // right and left corner of the one, and of the other
  for (int k = 0; k < 2; ++k) {
    const Box& box = node.children[k].box;
    const Vec2 origin = view.origin;
    const double x = std::max(std::max(box.low.x - origin.x, origin.x - box.high.x), 0.0);
    const double y = std::max(std::max(box.low.y - origin.y, origin.y - box.high.y), 0.0);
    outlooks[k].square_distance = x * x + y * y;
    const Silhouette& seen =
        kSilhouettes[side(origin.y, box.low.y, box.high.y)][side(origin.x, box.low.x, box.high.x)];
    const double edges[] = {box.low.x, box.low.y, box.high.x, box.high.y};
    xs[2 * k] = edges[seen.right_x];
    ys[2 * k] = edges[seen.right_y];
    xs[2 * k + 1] = edges[seen.left_x];
    ys[2 * k + 1] = edges[seen.left_y];
  }
  const Doubles world_x = Load(xs) - view.origin.x;
  const Doubles world_y = Load(ys) - view.origin.y;
  const Doubles x = view.rotation.cos * world_x + view.rotation.sin * world_y;
  const Doubles y = view.rotation.cos * world_y - view.rotation.sin * world_x;
  const Doubles diamond_angles = DiamondAngles(x, y);
  double rights[kGroup], lefts[kGroup];
  Store(WidenedRight(diamond_angles), rights);
  Store(WidenedLeft(diamond_angles), lefts);
  for (int k = 0; k < 2; ++k) {
    if (!(outlooks[k].square_distance > 0.0)) continue;
    outlooks[k].runs = view.fan.BeamsIn({rights[2 * k], lefts[2 * k + 1]});
  }
}

/// Which of a node's children to draw first: the nearer one, and of those that the lidar is in, the
/// one whose middle is nearer.
FLATLAND_INLINE bool IsSecondNearer(const SegmentTree::Node& node, const Outlook* outlooks,
                                    Vec2 origin) {
  if (outlooks[0].square_distance != outlooks[1].square_distance) {
    return outlooks[1].square_distance < outlooks[0].square_distance;
  }
  const auto to_middle = [&](const Box& box) {
    const Vec2 way = 0.5 * (box.low + box.high) - origin;
    return Dot(way, way);
  };
  return to_middle(node.children[1].box) < to_middle(node.children[0].box);
}

FLATLAND_CLONES void DrawTree(const SegmentTree& walls, const View& view) {
  struct Waiting {
    const SegmentTree::Child* child;
    Outlook outlook;
  };
  Waiting waiting[SegmentTree::kMostDepth];
  int count = 0;
  const SegmentTree::Child* child = &walls.root();
  while (true) {
    const SegmentTree::Child* next = nullptr;
    if (child->is_leaf()) {
      DrawLeaf(walls.leaf(*child), view);
    } else {
      const SegmentTree::Node& node = walls.node(*child);
      Outlook outlooks[2];
      LookAt(node, view, outlooks);
      const int first = IsSecondNearer(node, outlooks, view.origin) ? 1 : 0;
      // The farther one waits: the nearer one may hide it meanwhile.
      waiting[count++] = {&node.children[1 - first], outlooks[1 - first]};
      if (!IsHidden(view.inverse, outlooks[first])) next = &node.children[first];
    }
    while (next == nullptr && count > 0) {
      --count;
      if (!IsHidden(view.inverse, waiting[count].outlook)) next = waiting[count].child;
    }
    if (next == nullptr) return;
    child = next;
  }
}

FLATLAND_CLONES void FindSeenIn(const Discs& discs, const View& view, double range,
                                std::vector<int>* seen) {
  const Doubles cos = Fill(view.rotation.cos), sin = Fill(view.rotation.sin);
  for (int group = 0; group < discs.count; group += kGroup) {
    const Doubles world_x = Load(&discs.x[group]) - view.origin.x;
    const Doubles world_y = Load(&discs.y[group]) - view.origin.y;
    const Doubles radius = Load(&discs.radius[group]);
    const Doubles square_distance = world_x * world_x + world_y * world_y;
    const Doubles nearest = Sqrt(square_distance) - radius;
    double distances[kGroup];
    Store(nearest, distances);
    if (!Any(nearest <= range)) continue;
    // The tangents, as vectors of no certain length: to the right and to the left of the disc.
    const Doubles x = cos * world_x + sin * world_y;
    const Doubles y = cos * world_y - sin * world_x;
    const Doubles along = Sqrt(square_distance - radius * radius);
    double from[kGroup], to[kGroup];
    Store(WidenedRight(DiamondAngles(along * x + radius * y, along * y - radius * x)), from);
    Store(WidenedLeft(DiamondAngles(along * x - radius * y, along * y + radius * x)), to);
    for (int k = 0; k < kGroup && group + k < discs.count; ++k) {
      if (distances[k] > range) continue;
      const bool is_around = !(distances[k] > 0.0);
      if (is_around || !IsHidden(view.inverse, {view.fan.BeamsIn({from[k], to[k]}),
                                                distances[k] * distances[k]})) {
        seen->push_back(group + k);
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

FLATLAND_CLONES void DrawSide(const BeamFan& fan, double* inverse, Vec2 a, Vec2 b, double cross) {
  for (const BeamFan::Run& run : fan.BeamsBetween(a, b)) {
    DrawOn(fan, inverse, run, a, b, 1.0 / cross);
  }
}

/// The distances that the greater of two inverse distances make.
FLATLAND_CLONES void Invert(const double* inverse, const double* other, int count, double beyond,
                            float* ranges) {
  for (int i = 0; i < count; ++i) {
    const double nearest = std::max(inverse[i], other[i]);
    ranges[i] = static_cast<float>(nearest > beyond ? 1.0 / nearest : kInfinity);
  }
}

}  // namespace

void Discs::Add(Vec2 center, double radius_of_it) {
  if (count == static_cast<int>(x.size())) {
    for (std::vector<double>* values : {&x, &y, &radius}) values->resize(count + kGroup, 0.0);
  }
  x[count] = center.x;
  y[count] = center.y;
  radius[count] = radius_of_it;
  ++count;
}

void DepthBuffer::Begin(const BeamFan& fan, double range) {
  fan_ = &fan;
  range_ = range;
  beyond_ = (1.0 - kRangeTolerance) / range;
  inverse_.assign(fan.padded_size(), beyond_);
  dull_.clear();
}

void DepthBuffer::Draw(const SegmentTree& walls, const Pose& lidar) {
  if (walls.segment_count() == 0) return;
  DrawTree(walls, {*fan_, inverse_.data(), {lidar.x, lidar.y}, Rotation(lidar.yaw)});
}

void DepthBuffer::DrawCircle(Vec2 center, double radius) {
  const double square_distance = Dot(center, center);
  const bool is_outside = square_distance > radius * radius;
  if (is_outside) DrawCircleOn(*fan_, inverse_.data(), center, radius, square_distance);
}

void DepthBuffer::DrawPolygon(const Vec2* corners, int count) {
  // Seen from outside, the sides that face the lidar run clockwise around it; from within, none.
  for (int i = 0; i < count; ++i) {
    const Vec2 corner = corners[i];
    const Vec2 next = corners[i + 1 < count ? i + 1 : 0];
    const double cross = Cross(next, corner);
    const bool faces_lidar = cross > kEdgeOn * Size(next) * Size(corner);
    if (faces_lidar) DrawSide(*fan_, inverse_.data(), next, corner, cross);
  }
}

const std::vector<int>& DepthBuffer::FindSeen(const Discs& discs, const Pose& lidar) {
  seen_.clear();
  FindSeenIn(discs, {*fan_, inverse_.data(), {lidar.x, lidar.y}, Rotation(lidar.yaw)}, range_,
             &seen_);
  return seen_;
}

void DepthBuffer::BeginReflecting() {
  dull_ = inverse_;
  for (double& inverse : inverse_) inverse *= 1.0 - kTie;
}

void DepthBuffer::GetRanges(float* ranges) const {
  const double* dull = dull_.empty() ? inverse_.data() : dull_.data();
  if (fan_->is_sorted()) {
    Invert(inverse_.data(), dull, fan_->size(), beyond_, ranges);
    return;
  }
  for (int rank = 0; rank < fan_->size(); ++rank) {
    Invert(&inverse_[rank], &dull[rank], 1, beyond_, &ranges[fan_->beams()[rank]]);
  }
}

void DepthBuffer::GetIntensities(float* intensities) const {
  std::fill_n(intensities, fan_->size(), 0.0f);
  for (int rank = 0; rank < fan_->size() && !dull_.empty(); ++rank) {
    const bool is_in_range = std::max(inverse_[rank], dull_[rank]) > beyond_;
    const bool reflects = is_in_range && inverse_[rank] > dull_[rank] * (1.0 - kTie);
    intensities[fan_->beams()[rank]] = reflects ? 255.0f : 0.0f;
  }
}

}  // namespace flatland
