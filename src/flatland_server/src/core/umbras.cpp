#include "umbras.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace flatland {
namespace {

constexpr int kWedges = 360;
/// Allowances for rounding errors: [m], and of an inverse distance.
constexpr double kRounding = 1e-9;
constexpr double kNearer = 1.0 + 1e-9;
/// The least distance of a line within a wedge is below that at its sides by no more than this.
const double kBulge = 1.0 / std::cos(M_PI / kWedges);

const BeamFan& Fan() {
  static const BeamFan fan(-M_PI, 2.0 * M_PI / kWedges, kWedges);
  return fan;
}

/// All points p with Dot(normal, p) >= offset. In a direction from the origin they begin at a
/// distance, of which this is the inverse; below zero if the direction leaves them.
struct HalfPlane {
  double InverseAlong(Vec2 direction) const {
    const double along = Dot(normal, direction);
    return offset > 0.0 ? along / offset : along < 0.0 ? -1.0 : HUGE_VAL;
  }

  Vec2 normal;
  double offset;
};

}  // namespace

Umbras::Umbras(const Box& from)
    : from_(from), middle_(0.5 * (from.low + from.high)), inverse_(kWedges, 0.0) {
  const Vec2 half = from.high - middle_;
  const Vec2 corners[] = {{-half.x, -half.y}, {half.x, -half.y}, half, {-half.x, half.y}};
  std::copy_n(corners, 4, corners_);
}

void Umbras::Add(const Occluder& occluder) {
  Vec2 right = occluder.line.a - middle_, left = occluder.line.b - middle_;
  if (Cross(right, left) < 0.0) std::swap(right, left);
  const Vec2 along = left - right;
  const double length = std::sqrt(Dot(along, along));
  HalfPlane behind{{along.y, -along.x}, Cross(right, left) + kRounding * length};
  for (const Vec2& corner : corners_) {
    if (Dot(behind.normal, corner) > behind.offset - 2.0 * kRounding * length) return;
  }
  if (occluder.chain != nullptr) {
    // All of the chain's box is before it.
    if (occluder.chain->Meets(from_)) return;
    const Vec2 low = occluder.chain->low - middle_, high = occluder.chain->high - middle_;
    behind.offset = std::max(behind.offset, std::max(along.y * low.x, along.y * high.x) -
                                                std::min(along.x * low.y, along.x * high.y));
  }
  // The lines past an end from the corner that leaves least.
  const auto past = [&](Vec2 end, double side) {
    Vec2 way = end - corners_[0];
    for (const Vec2& corner : corners_) {
      if (side * Cross(way, end - corner) > 0.0) way = end - corner;
    }
    return way;
  };
  const Vec2 past_right = past(right, 1.0), past_left = past(left, -1.0);
  if (Cross(past_right, past_left) <= 0.0) return;  // they meet: the umbra ends
  const auto side_of = [&](Vec2 end, Vec2 normal) {
    return HalfPlane{normal, Dot(normal, end) + kRounding * std::sqrt(Dot(normal, normal))};
  };
  const HalfPlane sides[] = {side_of(right, {-past_right.y, past_right.x}),
                             side_of(left, {past_left.y, -past_left.x})};
  const BeamFan& fan = Fan();
  double last = -1.0;
  for (const BeamFan::Run& run : fan.BeamsBetween(past_right, past_left)) {
    for (int rank = run.begin; rank < run.end; ++rank) {
      const Vec2 way{fan.xs()[rank], fan.ys()[rank]};
      const double inverse = std::min(
          {behind.InverseAlong(way), sides[0].InverseAlong(way), sides[1].InverseAlong(way)});
      double& wedge = inverse_[rank == 0 ? kWedges - 1 : rank - 1];
      wedge = std::max(wedge, std::min(last, inverse));
      last = inverse;
    }
  }
}

template <class Inverse>
bool Umbras::BeginBefore(Vec2 right, Vec2 left, Inverse inverse) const {
  const auto runs = Fan().BeamsBetween(right, left);
  const auto is_hidden = [&](int wedge) { return inverse(wedge) * kNearer < inverse_[wedge]; };
  if (!is_hidden(runs[0].begin == 0 ? kWedges - 1 : runs[0].begin - 1)) return false;
  for (const BeamFan::Run& run : runs) {
    for (int rank = run.begin; rank < run.end; ++rank) {
      if (!is_hidden(rank)) return false;
    }
  }
  return true;
}

bool Umbras::Hide(const Segment& wall) const {
  Box box;
  box.Add(wall);
  if (box.Meets(from_)) return false;
  Vec2 right = wall.a - middle_, left = wall.b - middle_;
  if (Cross(right, left) < 0.0) std::swap(right, left);
  const double cross = Cross(right, left);
  const Vec2 along = left - right, normal{along.y, -along.x};
  const double nearest = 1.0 / std::sqrt(box.SquareDistance(middle_));
  const BeamFan& fan = Fan();
  const Vec2 scaled = (kBulge / cross) * normal;
  const auto at = [&](int rank) { return Dot(scaled, {fan.xs()[rank], fan.ys()[rank]}); };
  return BeginBefore(right, left, [&](int wedge) {
    const double inverse = std::max(at(wedge), at(wedge + 1 == kWedges ? 0 : wedge + 1));
    return inverse < nearest ? inverse : nearest;
  });
}

bool Umbras::Hide(const Box& box) const {
  // What is in it is behind those of its sides that face the middle.
  if (box.Meets(from_)) return false;
  const Vec2 low = box.low, high = box.high;
  const bool is_right = middle_.x<low.x, is_left = middle_.x> high.x;
  const bool is_above = middle_.y<low.y, is_below = middle_.y> high.y;
  const double x = is_right ? low.x : high.x, y = is_above ? low.y : high.y;
  return (!(is_right || is_left) || Hide(Segment{{x, low.y}, {x, high.y}})) &&
         (!(is_above || is_below) || Hide(Segment{{low.x, y}, {high.x, y}}));
}

}  // namespace flatland
