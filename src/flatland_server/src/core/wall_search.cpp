#include "wall_search.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "flatland_server/depth_buffer.hpp"
#include "umbras.hpp"

namespace flatland {
namespace {

/// A wall reaches past its ends by this fraction of its length, as it does for DepthBuffer.
constexpr double kEndTolerance = 1e-9;
/// Cells and walls are halved, and lines followed, this many times before a wall counts as seen.
constexpr int kMaxHalvings = 7;
constexpr int kMaxLines = 32;
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

/// A wall that may be hidden, or a part of one.
struct Target {
  explicit Target(const Segment& wall) : ends{wall.a, wall.b}, bounds(BoxOf(wall)) {}

  std::array<Target, 2> Halves() const {
    const Vec2 middle = 0.5 * (ends[0] + ends[1]);
    return {Target(Segment{ends[0], middle}), Target(Segment{middle, ends[1]})};
  }

  std::array<Vec2, 2> ends;
  Box bounds;
};

Vec2 Middle(const Target& target) { return 0.5 * (target.ends[0] + target.ends[1]); }

/// True if a line between these boxes that crosses the occluder is blocked by it: a wall blocks all
/// lines, a chord those that begin and end outside of its chain's box.
bool Counts(const Occluder& occluder, const Box& from, const Target& target) {
  return occluder.chain == nullptr ||
         (AreApart(*occluder.chain, from) && AreApart(*occluder.chain, target.bounds));
}

/// True if an occluder crosses all lines from a box to a target. They all cross its line between
/// the points where those from corner to end do. A wall may touch one that it hides, as at the
/// edges of a pillar, but not lie in its line. Lines may pass a wall just past its ends, but a
/// chord only before them.
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
  for (const Vec2& end : target.ends) {
    const double depth = -side * Cross(along, end - wall.a);
    if (depth < 0.0) return false;
    is_behind = is_behind || depth > tolerance;
    for (int i = 0; i < 4; ++i) {
      // Where the line from corner i to this end crosses, from 0 to 1 along the wall.
      const Vec2 way = heights[i] * (end - wall.a) + depth * (corners[i] - wall.a);
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
  bool Meets(const Segment& segment) const {
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
    Vec2 one = farthest(corners.data(), 4), other = farthest(target.ends.data(), 2);
    for (int turns = 0; turns < 2; ++turns) {
      const Vec2 way = other - one, across{-way.y, way.x};
      const double sign = Dot(across, normal);
      if (sign == 0.0) break;
      normal = sign > 0.0 ? across : -1.0 * across;
      one = farthest(corners.data(), 4);
      other = farthest(target.ends.data(), 2);
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
      : walls_(walls),
        occluders_(occluders),
        from_(from),
        places_(occluders.outlines().size()),
        umbras_(from) {
    if (walls.segment_count() == 0) return;
    if (among == nullptr) {
      unsearched_.push_back(occluders.tree().root());
      pending_.push_back({walls.root(), false});
      return;
    }
    const std::vector<bool> counts = occluders.AreOf(*among);
    for (size_t leaf = 0; leaf < occluders.tree().leaf_count(); ++leaf) {
      AddNear(leaf, [&](uint32_t index) { return counts[index]; });
    }
    for (auto i = among->rbegin(); i != among->rend(); ++i) {
      pending_.push_back({{{}, static_cast<int32_t>(*i)}, true});
    }
  }

  bool Continue(int effort) {
    effort_ = effort;
    while (effort_ > 0 && (!parts_.empty() || !pending_.empty())) {
      --effort_;
      if (samples_.size() < kSamples) {
        AddSample();
      } else if (!unsearched_.empty()) {
        CollectOccluders();
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
  /// Neighbours among the near occluders, up to that with the index `end`.
  struct Group {
    Box box;
    size_t end;
  };

  static constexpr size_t kRecent = 8;

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
      if (cross == 0.0) continue;  // seen edge-on, or from an end
      const Vec2 &right = cross > 0.0 ? a : b, &left = cross > 0.0 ? b : a;
      for (const BeamFan::Run& run : Fan().BeamsBetween(right, left)) {
        for (int k = run.begin; k < run.end; ++k) {
          const Vec2 way = Fan().direction(k);
          if (Cross(way, right) > 0.0 || Cross(way, left) < 0.0) continue;
          const double reached = sample.ranges[k] * (1.0 + 1e-6) * std::abs(Cross(way, along));
          if (std::abs(cross) <= reached) return true;
        }
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
    effort_ -= 15;
    const Pending next = pending_.back();
    pending_.pop_back();
    if (next.is_wall) {
      wall_ = static_cast<uint32_t>(next.child.index);
      if (TurnsBack(wall_)) return;
      if (IsSampled(wall_)) {
        seen_.push_back(wall_);
        return;
      }
      const Target target(walls_.segments()[wall_]);
      if (umbras_.Hide(walls_.segments()[wall_]) || IsHiddenByOne(target)) return;
      CollectCandidates(target);
      lines_ = kMaxLines;
      parts_.push_back({from_, target, kMaxHalvings, 0, candidates_.size()});
      return;
    }
    const SegmentTree::Child& child = next.child;
    if (umbras_.Hide(child.box)) return;
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
    const Part part = parts_.back();
    parts_.pop_back();
    const bool may_be_hidden = AreApart(part.from, part.target.bounds) && lines_-- > 0;
    if (may_be_hidden && IsHiddenOrDivided(part)) return;
    parts_.clear();
    seen_.push_back(wall_);
  }

  /// Adds the occluders in a box to the umbras, the nearer ones first, but those that are hidden.
  void CollectOccluders() {
    const SegmentTree::Child child = unsearched_.back();
    unsearched_.pop_back();
    if (umbras_.Hide(child.box)) return;
    const SegmentTree& tree = occluders_.tree();
    if (!child.is_leaf()) {
      const SegmentTree::Child* nearer = tree.node(child).children;
      const SegmentTree::Child* farther = nearer + 1;
      const Vec2 middle = Middle(from_);
      if (farther->box.SquareDistance(middle) < nearer->box.SquareDistance(middle)) {
        std::swap(nearer, farther);
      }
      unsearched_.push_back(*farther);
      unsearched_.push_back(*nearer);
      return;
    }
    AddNear(static_cast<size_t>(~child.index), [&](uint32_t index) {
      effort_ -= 15;
      const Occluder each = occluders_.Get(index);
      if (umbras_.Hide(each.line)) return false;
      umbras_.Add(each);
      return true;
    });
  }

  /// Adds those occluders of a leaf that count to the near ones.
  template <class Counts>
  void AddNear(size_t leaf, Counts counts) {
    Group group;
    occluders_.tree().ForEachWall(leaf, [&](uint32_t index) {
      if (!counts(index)) return true;
      near_.push_back(occluders_.Get(index));
      group.box.Add(near_.back().line);
      return true;
    });
    group.end = near_.size();
    if (group.end > (groups_.empty() ? 0 : groups_.back().end)) groups_.push_back(group);
  }

  /// Calls `visit(occluder)` for the near ones that a place meets while it returns true; returns
  /// whether it did.
  template <class Place, class Visit>
  bool ForEachNear(const Place& place, const Visit& visit) {
    effort_ -= static_cast<int>(groups_.size()) / 2;
    size_t i = 0;
    for (const Group& group : groups_) {
      if (place.Meets(group.box)) {
        for (; i < group.end; ++i) {
          if (place.Meets(near_[i].line) && !visit(near_[i])) return false;
        }
      }
      i = group.end;
    }
    return true;
  }

  /// True if a single occluder hides it all: one that has hidden others, or one that its middle
  /// line meets.
  bool IsHiddenByOne(const Target& target) {
    if (!AreApart(from_, target.bounds)) return false;
    const auto hides = [&](const Occluder& each) { return Blocks(each, from_, target); };
    const auto known = std::find_if(recent_.begin(), recent_.end(), hides);
    if (known != recent_.end()) {
      std::rotate(recent_.begin(), known, known + 1);
      return true;
    }
    return !ForEachNear(Line(Middle(from_), Middle(target)), [&](const Occluder& each) {
      if (!hides(each)) return true;
      if (recent_.size() == kRecent) recent_.pop_back();
      recent_.insert(recent_.begin(), each);
      return false;
    });
  }

  /// Collects what may hide a part of a target.
  void CollectCandidates(const Target& target) {
    candidates_.clear();
    ForEachNear(Shaft(from_, target), [&](const Occluder& each) {
      if (Counts(each, from_, target)) candidates_.push_back(each);
      return true;
    });
  }

  /// `part` has the candidates for a part around it; those that may hide this one are put behind
  /// them. True if a candidate hides it, or else one blocks its middle line, so that its halves may
  /// be hidden, which are to be visited then.
  bool IsHiddenOrDivided(const Part& part) {
    const Line line(Middle(part.from), Middle(part.target));
    effort_ -= static_cast<int>(part.end - part.begin);
    bool is_blocked = false;
    for (size_t i = part.begin; i < part.end; ++i) {
      const Occluder& each = candidates_[i];
      if (!line.Meets(each.line) || !Counts(each, part.from, part.target)) continue;
      is_blocked = true;
      const bool is_whole = part.halvings == kMaxHalvings;  // IsHiddenByOne has tried these
      if (!is_whole && Blocks(each, part.from, part.target)) return true;
    }
    if (!is_blocked || part.halvings == 0) return false;
    const Shaft shaft(part.from, part.target);
    candidates_.resize(part.end);
    for (size_t i = part.begin; i < part.end; ++i) {
      const Occluder each = candidates_[i];
      const bool counts = Counts(each, part.from, part.target);
      if (counts && shaft.Meets(each.line)) candidates_.push_back(each);
    }
    const size_t begin = part.end, end = candidates_.size();
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

  const SegmentTree& walls_;
  const Occluders& occluders_;
  const Box from_;
  std::vector<Place> places_;  // of the cell, by outline
  std::vector<Sample> samples_;
  DepthBuffer buffer_;
  Umbras umbras_;
  std::vector<SegmentTree::Child> unsearched_;  // boxes with occluders
  std::vector<Occluder> near_;                  // those that others do not hide
  std::vector<Group> groups_;                   // of them
  std::vector<Occluder> recent_;                // those that have hidden others, the last one first
  int effort_ = 0;                              // that is left in this portion
  std::vector<Pending> pending_;                // the next one last, as in those below
  std::vector<uint32_t> seen_;

  uint32_t wall_ = 0;                 // the present one
  std::vector<Part> parts_;           // of the present wall
  int lines_ = 0;                     // that may still be followed for it
  std::vector<Occluder> candidates_;  // what may hide a part of it
};

WallSearch::WallSearch(const SegmentTree& walls, const Occluders& occluders, const Box& from,
                       const std::vector<uint32_t>* among)
    : finder_(std::make_unique<Finder>(walls, occluders, from, among)) {}

WallSearch::~WallSearch() = default;

bool WallSearch::Continue(int effort) { return finder_->Continue(effort); }

const std::vector<uint32_t>& WallSearch::seen() const { return finder_->seen(); }

}  // namespace flatland
