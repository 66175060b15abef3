#include "wall_search.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include "flatland_server/depth_buffer.hpp"

namespace flatland {
namespace {

/// A wall reaches past its ends by this fraction of its length, as it does for DepthBuffer.
constexpr double kEndTolerance = 1e-9;
/// Cells and walls are halved, and lines followed, this many times before a wall counts as seen.
constexpr int kMaxHalvings = 7;
constexpr int kMaxLines = 16;
/// Scans from the corners of the cell find walls that are seen for sure: nothing is to be proven.
constexpr size_t kSamples = 4;
constexpr int kSampleBeams = 720;
constexpr int kSampleEffort = 1000;
/// Allowance for rounding errors [m].
constexpr double kRounding = 1e-9;

Vec2 Middle(const Box& box) { return 0.5 * (box.low + box.high); }
Box BoxOf(const Segment& segment) {
  Box box;
  box.Add(segment);
  return box;
}
std::array<Vec2, 4> CornersOf(const Box& box) {
  return {box.low, {box.high.x, box.low.y}, box.high, {box.low.x, box.high.y}};
}
bool AreApart(const Box& a, const Box& b) { return !a.Meets(b); }

/// The two halves of a box, across its longer side.
std::array<Box, 2> Halves(const Box& box) {
  std::array<Box, 2> halves{box, box};
  const Vec2 middle = Middle(box);
  if (box.high.x - box.low.x > box.high.y - box.low.y) {
    halves[0].high.x = halves[1].low.x = middle.x;
  } else {
    halves[0].high.y = halves[1].low.y = middle.y;
  }
  return halves;
}

/// A wall that may be hidden, or a box with walls.
struct Target {
  explicit Target(const Box& box) : corners(CornersOf(box)), count(4), bounds(box) {}
  explicit Target(const Segment& wall)
      : corners{wall.a, wall.b, {}, {}}, count(2), bounds(BoxOf(wall)) {}

  std::array<Target, 2> Halves() const {
    if (count == 4) {
      const auto [low, high] = flatland::Halves(bounds);
      return {Target(low), Target(high)};
    }
    const Vec2 middle = 0.5 * (corners[0] + corners[1]);
    return {Target(Segment{corners[0], middle}), Target(Segment{middle, corners[1]})};
  }

  std::array<Vec2, 4> corners;
  int count;
  Box bounds;
};

Vec2 Middle(const Target& target) {
  return target.count == 4 ? Middle(target.bounds) : 0.5 * (target.corners[0] + target.corners[1]);
}

/// True if a line between these boxes that crosses the occluder is blocked by it: a wall blocks all
/// lines, a chord those that begin and end outside of its chain's box.
bool Counts(const Occluder& occluder, const Box& from, const Target& target) {
  return occluder.chain == nullptr ||
         (AreApart(*occluder.chain, from) && AreApart(*occluder.chain, target.bounds));
}

/// True if an occluder crosses all lines from a box to a target. They all cross its line between
/// the points where those from corner to corner do. A wall may touch one that it hides, as at the
/// edges of a pillar, but neither lie in its line nor touch a box, which may be that of the wall
/// itself. Lines may pass a wall just past its ends, but a chord only before them.
bool Blocks(const Occluder& occluder, const Box& from, const Target& target) {
  if (!Counts(occluder, from, target)) return false;
  const Segment& wall = occluder.line;
  const double past_ends = occluder.chain == nullptr ? kEndTolerance : -kEndTolerance;
  const Vec2 along = wall.b - wall.a;
  const std::array<Vec2, 4> corners = CornersOf(from);
  double heights[4];  // above the line of the wall, times its length
  for (int i = 0; i < 4; ++i) heights[i] = Cross(along, corners[i] - wall.a);
  const double side = heights[0] > 0.0 ? 1.0 : -1.0;
  const double square_length = Dot(along, along);
  const double tolerance = kEndTolerance * square_length;
  for (double& height : heights) {
    height *= side;
    if (height <= tolerance) return false;
  }
  bool is_behind = false;
  for (int k = 0; k < target.count; ++k) {
    const double depth = -side * Cross(along, target.corners[k] - wall.a);
    if (depth < 0.0 || (target.count == 4 && depth <= tolerance)) return false;
    is_behind = is_behind || depth > tolerance;
    for (int i = 0; i < 4; ++i) {
      // Where the line from corner i to corner k crosses, from 0 to 1 along the wall.
      const Vec2 way = heights[i] * (target.corners[k] - wall.a) + depth * (corners[i] - wall.a);
      const double place = Dot(along, way);
      const double whole = (heights[i] + depth) * square_length;
      if (place < -past_ends * whole || place > (1.0 + past_ends) * whole) return false;
    }
  }
  return is_behind;
}

/// Where an interval lies, as seen from another one.
bool AreApart(double low, double high, double from, double to) { return high < from || low > to; }

/// A line from a to b.
class Line {
 public:
  Line(Vec2 a, Vec2 b) : a_(a), b_(b), way_(b - a) {}

  bool Meets(const Box& box) const {
    if (AreApart(std::min(a_.x, b_.x), std::max(a_.x, b_.x), box.low.x, box.high.x)) return false;
    if (AreApart(std::min(a_.y, b_.y), std::max(a_.y, b_.y), box.low.y, box.high.y)) return false;
    const Vec2 half = 0.5 * (box.high - box.low);
    const double reach = std::abs(way_.x) * half.y + std::abs(way_.y) * half.x;
    return std::abs(Cross(way_, Middle(box) - a_)) <= reach * (1.0 + 1e-9) + 1e-12;
  }
  /// True if it crosses a segment before its end.
  bool Crosses(const Segment& segment) const {
    const double right = Cross(way_, segment.a - a_), left = Cross(way_, segment.b - a_);
    if ((right > 0.0 && left > 0.0) || (right < 0.0 && left < 0.0)) return false;
    const Vec2 along = segment.b - segment.a;
    const double before = Cross(along, a_ - segment.a), behind = Cross(along, b_ - segment.a);
    if (before == 0.0) return false;
    return before > 0.0 ? behind < -1e-9 * before : behind > -1e-9 * before;
  }

 private:
  Vec2 a_, b_, way_;
};

/// All lines from a box to a target, and perhaps more: what lies between the two lines that touch
/// both from the left and from the right.
class Shaft {
 public:
  Shaft(const Box& from, const Target& target) : bounds_(from) {
    bounds_.Add(target.bounds);
    const Vec2 way = Middle(target) - Middle(from);
    sides_[0] = SideOf(from, target, {-way.y, way.x});
    sides_[1] = SideOf(from, target, {way.y, -way.x});
  }

  bool Meets(const Box& box) const {
    if (flatland::AreApart(box, bounds_)) return false;
    const Vec2 middle = Middle(box), half = 0.5 * (box.high - box.low);
    const auto is_within = [&](const Side& side) {
      const double reach = std::abs(side.normal.x) * half.x + std::abs(side.normal.y) * half.y;
      return Dot(side.normal, middle) - reach <= side.limit;
    };
    return is_within(sides_[0]) && is_within(sides_[1]);
  }
  bool Meets(const Segment& line) const {
    if (AreApart(std::min(line.a.x, line.b.x), std::max(line.a.x, line.b.x), bounds_.low.x,
                 bounds_.high.x) ||
        AreApart(std::min(line.a.y, line.b.y), std::max(line.a.y, line.b.y), bounds_.low.y,
                 bounds_.high.y)) {
      return false;
    }
    const auto is_within = [&](const Side& side) {
      return std::min(Dot(side.normal, line.a), Dot(side.normal, line.b)) <= side.limit;
    };
    return is_within(sides_[0]) && is_within(sides_[1]);
  }

 private:
  /// All points p with Dot(normal, p) <= limit.
  struct Side {
    Vec2 normal;
    double limit;
  };

  /// Begins with a line across `normal`, and turns it until it touches both.
  static Side SideOf(const Box& from, const Target& target, Vec2 normal) {
    const std::array<Vec2, 4> corners = CornersOf(from);
    const auto farthest = [&normal](const Vec2* points, int count) {
      Vec2 found = points[0];
      for (int i = 1; i < count; ++i) {
        if (Dot(normal, points[i]) > Dot(normal, found)) found = points[i];
      }
      return found;
    };
    Vec2 one = farthest(corners.data(), 4), other = farthest(target.corners.data(), target.count);
    for (int turns = 0; turns < 2; ++turns) {
      const Vec2 way = other - one, across{-way.y, way.x};
      const double sign = Dot(across, normal);
      if (sign == 0.0) break;
      normal = sign > 0.0 ? across : -1.0 * across;
      one = farthest(corners.data(), 4);
      other = farthest(target.corners.data(), target.count);
    }
    return {normal, std::max(Dot(normal, one), Dot(normal, other))};
  }

  Box bounds_;
  Side sides_[2];
};

}  // namespace

class WallSearch::Finder {
 public:
  Finder(const SegmentTree& walls, const Occluders& occluders, const Box& from,
         const std::vector<uint32_t>* among)
      : walls_(walls), occluders_(occluders), from_(from), places_(occluders.outlines().size()) {
    if (among != nullptr) {
      for (auto i = among->rbegin(); i != among->rend(); ++i) {
        pending_.push_back({{{}, static_cast<int32_t>(*i)}, true});
      }
      among_ = occluders.AreOf(*among);
    } else if (walls.segment_count() > 0) {
      pending_.push_back({walls.root(), false});
    }
  }

  bool Continue(int effort) {
    effort_ = effort;
    while (effort_ > 0 && (!parts_.empty() || !pending_.empty())) {
      --effort_;
      if (samples_.size() < kSamples) {
        AddSample();
      } else if (!unsearched_.empty()) {
        CollectCandidates();
      } else if (!parts_.empty()) {
        VisitPart();
      } else {
        VisitPending();
      }
    }
    return parts_.empty() && pending_.empty();
  }

  const std::vector<uint32_t>& seen() const { return seen_; }

 private:
  static constexpr int kRecent = 8;

  /// Where the cell is, as seen from an outline.
  enum class Place : uint8_t { kUnknown, kInside, kOutside, kOnIt };

  /// A scan from a point of the cell.
  struct Sample {
    Vec2 point;
    std::vector<float> ranges;
  };

  static const BeamFan& Fan() {
    static const BeamFan fan(-M_PI, 2.0 * M_PI / kSampleBeams, kSampleBeams);
    return fan;
  }

  void AddSample() {
    const Vec2 point = CornersOf(from_)[samples_.size()];
    Sample& sample = samples_.emplace_back(Sample{point, std::vector<float>(kSampleBeams)});
    buffer_.Begin(Fan(), 1e9);
    buffer_.Draw(walls_, {point.x, point.y, 0.0});
    buffer_.GetRanges(sample.ranges.data());
    effort_ -= kSampleEffort;
  }

  /// True if a beam of a sample ends on a wall.
  bool IsSampled(uint32_t wall) {
    const Segment& line = walls_.segments()[wall];
    for (const Sample& sample : samples_) {
      const Vec2 a = line.a - sample.point, b = line.b - sample.point, along = b - a;
      const double cross = Cross(a, b);
      const Vec2 &right = cross > 0.0 ? a : b, &left = cross > 0.0 ? b : a;
      const double unit = kSampleBeams / (2.0 * M_PI);
      int beam = static_cast<int>((std::atan2(right.y, right.x) + M_PI) * unit) + 1;
      double width = std::atan2(std::abs(cross), Dot(a, b)) * unit;
      for (int n = static_cast<int>(width); n >= 0; --n, ++beam) {
        const int k = beam % kSampleBeams;
        const Vec2 way = Fan().direction(k);
        const double across = Cross(way, along);
        const double distance = Cross(a, along) / across;
        if (Cross(way, right) > 0.0 || Cross(way, left) < 0.0) continue;
        if (distance <= sample.ranges[k] * (1.0 + 1e-6)) return true;
      }
    }
    return false;
  }

  /// A box of the tree, or a wall, that is still to be looked at.
  struct Pending {
    SegmentTree::Child child;  // of a wall, only `index` counts: in segments()
    bool is_wall;
  };

  /// A part of the present wall, and of the box from which it may be seen.
  struct Part {
    Box from;
    Target target;
    int halvings;       // that may still be made
    size_t begin, end;  // in candidates_: what may hide a part around it
  };

  void VisitPending() {
    const Pending next = pending_.back();
    pending_.pop_back();
    if (next.is_wall) {
      wall_ = static_cast<uint32_t>(next.child.index);
      if (TurnsBack(wall_)) return;
      if (IsSampled(wall_)) {
        seen_.push_back(wall_);
        return;
      }
      shaft_.reset();
      candidates_.clear();
      lines_ = kMaxLines;
      parts_.push_back({from_, Target(walls_.segments()[wall_]), kMaxHalvings, 0, 0});
      return;
    }
    const SegmentTree::Child& child = next.child;
    if (AreApart(from_, child.box) && IsBoxHidden(Target(child.box))) return;
    const auto begin = static_cast<ptrdiff_t>(pending_.size());
    if (!child.is_leaf()) {
      for (const SegmentTree::Child& each : walls_.node(child).children) {
        pending_.push_back({each, false});
      }
    } else {
      walls_.ForEachWall(static_cast<size_t>(~child.index), [this](uint32_t index) {
        pending_.push_back({{{}, static_cast<int32_t>(index)}, true});
        return true;
      });
    }
    std::reverse(pending_.begin() + begin, pending_.end());
  }

  /// True if a single occluder hides it all; looks for it along one line.
  bool IsBoxHidden(const Target& target) {
    if (BlocksRecent(from_, target)) return true;
    const Line line(Middle(from_), Middle(target));
    return !occluders_.ForEachMeeting(line, [&](const Occluder& each) {
      --effort_;
      const bool is_hidden = line.Crosses(each.line) && Blocks(each, from_, target);
      if (is_hidden) Remember(each);
      return !is_hidden;
    });
  }

  /// True if a wall is hidden by others of its outline: all of the cell is behind its back.
  bool TurnsBack(uint32_t wall) {
    const Occluders::Side side = occluders_.SideOf(wall);
    if (side.outline < 0) return false;
    Place& place = places_[side.outline];
    if (place == Place::kUnknown) place = PlaceIn(occluders_.outlines()[side.outline]);
    if (place == Place::kOnIt) return false;
    const bool is_front_left = (place == Place::kInside) == side.is_inside_left;
    const Segment& line = walls_.segments()[wall];
    const Vec2 along = line.b - line.a;
    for (const Vec2& corner : CornersOf(from_)) {
      const double left = Cross(along, corner - line.a);
      if ((is_front_left ? left : -left) > -kRounding * (std::abs(along.x) + std::abs(along.y))) {
        return false;
      }
    }
    return true;
  }

  Place PlaceIn(const Occluders::Outline& outline) const {
    const Vec2 middle = Middle(from_);
    bool is_inside = false;
    for (size_t i = outline.begin; i < outline.end; ++i) {
      const Segment& line = walls_.segments()[occluders_.in_order()[i]];
      if (!AreApart(BoxOf(line), from_)) return Place::kOnIt;
      const Vec2 a = line.a - middle, b = line.b - middle;
      if ((a.y > 0.0) != (b.y > 0.0) && (Cross(a, b) > 0.0) == (b.y > a.y)) is_inside = !is_inside;
    }
    return is_inside ? Place::kInside : Place::kOutside;
  }

  /// The present wall is hidden if all of its parts are.
  void VisitPart() {
    Part part = parts_.back();
    const bool may_be_hidden = AreApart(part.from, part.target.bounds);
    if (may_be_hidden && BlocksRecent(part.from, part.target)) {
      parts_.pop_back();
    } else if (may_be_hidden && !shaft_) {
      if (IsBoxHidden(part.target)) {
        parts_.pop_back();
        return;
      }
      // It is visited again when what may hide the wall has been collected.
      shaft_.emplace(from_, Target(walls_.segments()[wall_]));
      unsearched_.push_back(occluders_.tree().root());
    } else {
      parts_.pop_back();
      if (part.halvings == kMaxHalvings) part.end = candidates_.size();
      if (may_be_hidden && lines_-- > 0 && IsHiddenOrDivided(part)) return;
      parts_.clear();
      seen_.push_back(wall_);
    }
  }

  /// Collects what may hide a part of the present wall from a box of the tree.
  void CollectCandidates() {
    const SegmentTree::Child child = unsearched_.back();
    unsearched_.pop_back();
    if (!shaft_->Meets(child.box)) return;
    if (!child.is_leaf()) {
      const auto& children = occluders_.tree().node(child).children;
      unsearched_.push_back(children[1]);
      unsearched_.push_back(children[0]);
      return;
    }
    occluders_.tree().ForEachWall(static_cast<size_t>(~child.index), [&](uint32_t index) {
      --effort_;
      if (!among_.empty() && !among_[index]) return true;
      const Occluder each = occluders_.Get(index);
      if (shaft_->Meets(each.line)) candidates_.push_back(each);
      return true;
    });
  }

  /// `part` has the candidates for a part around it; those that may hide this one are put behind
  /// them. True if a candidate hides it, or else one blocks its middle line, so that its halves may
  /// be hidden, which are to be visited then.
  bool IsHiddenOrDivided(const Part& part) {
    const Line line(Middle(part.from), Middle(part.target));
    const Shaft shaft(part.from, part.target);
    candidates_.resize(part.end);
    bool is_blocked = false;
    for (size_t i = part.begin; i < part.end; ++i) {
      const Occluder each = candidates_[i];
      --effort_;
      if (!shaft.Meets(each.line) || !Counts(each, part.from, part.target)) continue;
      candidates_.push_back(each);
      if (!line.Crosses(each.line)) continue;
      is_blocked = true;
      if (!Blocks(each, part.from, part.target)) continue;
      Remember(each);
      return true;
    }
    const size_t begin = part.end, end = candidates_.size();
    if (!is_blocked || part.halvings == 0) return false;
    const Vec2 size = part.from.high - part.from.low;
    const Vec2 target_size = part.target.bounds.high - part.target.bounds.low;
    if (std::max(size.x, size.y) > std::max(target_size.x, target_size.y)) {
      const auto [low, high] = Halves(part.from);
      parts_.push_back({high, part.target, part.halvings - 1, begin, end});
      parts_.push_back({low, part.target, part.halvings - 1, begin, end});
    } else {
      const auto [first, second] = part.target.Halves();
      parts_.push_back({part.from, second, part.halvings - 1, begin, end});
      parts_.push_back({part.from, first, part.halvings - 1, begin, end});
    }
    return true;
  }

  /// True if one of the occluders that have hidden other targets blocks all lines.
  bool BlocksRecent(const Box& from, const Target& target) {
    for (int i = 0; i < recent_count_; ++i) {
      if (!Blocks(recent_[i], from, target)) continue;
      std::rotate(recent_.begin(), recent_.begin() + i, recent_.begin() + i + 1);
      return true;
    }
    return false;
  }

  void Remember(const Occluder& occluder) {
    recent_count_ = std::min(recent_count_ + 1, kRecent);
    std::rotate(recent_.begin(), recent_.begin() + recent_count_ - 1,
                recent_.begin() + recent_count_);
    recent_[0] = occluder;
  }

  const SegmentTree& walls_;
  const Occluders& occluders_;
  const Box from_;
  std::vector<Place> places_;  // of the cell, by outline
  std::vector<Sample> samples_;
  DepthBuffer buffer_;
  std::vector<bool> among_;       // for each occluder, whether it counts; empty if all do
  int effort_ = 0;                // that is left in this portion
  std::vector<Pending> pending_;  // the next one last, as in those below
  std::vector<uint32_t> seen_;
  std::array<Occluder, kRecent> recent_;  // those that have hidden others, the last one first
  int recent_count_ = 0;

  uint32_t wall_ = 0;                           // the present one
  std::vector<Part> parts_;                     // of the present wall
  int lines_ = 0;                               // that may still be followed for it
  std::optional<Shaft> shaft_;                  // all lines to it, if candidates are needed
  std::vector<SegmentTree::Child> unsearched_;  // boxes with candidates
  std::vector<Occluder> candidates_;            // what may hide a part of it
};

WallSearch::WallSearch(const SegmentTree& walls, const Occluders& occluders, const Box& from,
                       const std::vector<uint32_t>* among)
    : finder_(std::make_unique<Finder>(walls, occluders, from, among)) {}

WallSearch::~WallSearch() = default;

bool WallSearch::Continue(int effort) { return finder_->Continue(effort); }

const std::vector<uint32_t>& WallSearch::seen() const { return finder_->seen(); }

}  // namespace flatland
