#include "wall_search.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "corner_scans.hpp"
#include "four_occluders.hpp"
#include "sight_lines.hpp"
#include "umbras.hpp"

namespace flatland {
namespace {

/// Sight lines are halved, and parts of them visited, this many times before a wall counts as seen.
constexpr int kMaxHalvings = 7;
constexpr int kMaxParts = 32;
/// A scan takes as long as looking at so many occluders.
constexpr int kScanEffort = 1000;
/// Allowance for rounding errors [m].
constexpr double kRounding = 1e-9;

}  // namespace

class WallSearch::Finder {
 public:
  Finder(const SegmentTree& walls, const Occluders& occluders, const Box& from,
         const std::vector<uint32_t>* among)
      : walls_(walls),
        occluders_(occluders),
        from_(from),
        places_(occluders.outlines().size()),
        scans_(walls, from),
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
      if (scans_.MakeNext()) {
        effort_ -= kScanEffort;
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
  /// Where the cell is, as seen from an outline.
  enum class Place : uint8_t { kUnknown, kInside, kOutside, kOnIt };

  /// A box of the tree, or a wall, that is still to be looked at.
  struct Pending {
    SegmentTree::Child child;  // of a wall, only `index` counts: in segments()
    bool is_wall;
  };

  /// Sight lines to the present wall, or a part of them.
  struct Part {
    SightLines lines;
    int halvings;       // that may still be made
    size_t begin, end;  // in candidates_: what may block lines around these
  };

  void VisitPending() {
    effort_ -= 15;
    const Pending next = pending_.back();
    pending_.pop_back();
    if (next.is_wall) {
      wall_ = static_cast<uint32_t>(next.child.index);
      if (TurnsBack(wall_)) return;
      if (scans_.See(walls_.segments()[wall_])) {
        seen_.push_back(wall_);
        return;
      }
      const SightLines lines(from_, walls_.segments()[wall_]);
      effort_ -= static_cast<int>(near_.size());
      if (umbras_.Hide(lines.to) || (lines.HaveLength() && near_.Block(lines))) return;
      candidates_.clear();
      near_.Collect(Shaft(lines), lines, &candidates_);
      parts_left_ = kMaxParts;
      parts_.push_back({lines, kMaxHalvings, 0, candidates_.size()});
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
      if (BoxOf(line).Meets(from_)) return Place::kOnIt;
      const Vec2 a = line.a - middle, b = line.b - middle;
      if ((a.y > 0.0) != (b.y > 0.0) && (Cross(a, b) > 0.0) == (b.y > a.y)) is_inside = !is_inside;
    }
    return is_inside ? Place::kInside : Place::kOutside;
  }

  /// The present wall is hidden if all of its parts are.
  void VisitPart() {
    const Part part = parts_.back();
    parts_.pop_back();
    const bool may_be_hidden = part.lines.HaveLength() && parts_left_-- > 0;
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
    occluders_.tree().ForEachWall(leaf, [&](uint32_t index) {
      if (!counts(index)) return true;
      const Occluder each = occluders_.Get(index);
      if (each.chain == nullptr || !each.chain->Meets(from_)) near_.Add(each);
      return true;
    });
  }

  /// True if a candidate blocks all lines of a part, or else one blocks its middle line, so that
  /// its halves may be hidden, which are to be visited then.
  bool IsHiddenOrDivided(const Part& part) {
    effort_ -= static_cast<int>(part.end - part.begin);
    using Crossed = OccluderField::Crossed;
    const Crossed crossed = near_.Cross(part.lines, candidates_, part.begin, part.end);
    if (crossed == Crossed::kAll) return true;
    if (crossed == Crossed::kNone || part.halvings == 0) return false;
    candidates_.resize(part.end);
    near_.Narrow(Shaft(part.lines), part.begin, &candidates_);
    const auto [first, second] = part.lines.Halves();
    parts_.push_back({second, part.halvings - 1, part.end, candidates_.size()});
    parts_.push_back({first, part.halvings - 1, part.end, candidates_.size()});
    return true;
  }

  const SegmentTree& walls_;
  const Occluders& occluders_;
  const Box from_;
  std::vector<Place> places_;  // of the cell, by outline
  CornerScans scans_;
  Umbras umbras_;
  std::vector<SegmentTree::Child> unsearched_;  // boxes with occluders
  OccluderField near_;                          // those that others do not hide
  int effort_ = 0;                              // that is left in this portion
  std::vector<Pending> pending_;                // the next one last, as in those below
  std::vector<uint32_t> seen_;

  uint32_t wall_ = 0;                            // the present one
  std::vector<Part> parts_;                      // of the lines to it
  int parts_left_ = 0;                           // that may still be visited for it
  std::vector<OccluderField::Some> candidates_;  // what may block them
};

WallSearch::WallSearch(const SegmentTree& walls, const Occluders& occluders, const Box& from,
                       const std::vector<uint32_t>* among)
    : finder_(std::make_unique<Finder>(walls, occluders, from, among)) {}

WallSearch::~WallSearch() = default;

bool WallSearch::Continue(int effort) { return finder_->Continue(effort); }

const std::vector<uint32_t>& WallSearch::seen() const { return finder_->seen(); }

}  // namespace flatland
