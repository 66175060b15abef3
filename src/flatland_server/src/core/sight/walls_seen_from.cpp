/// Need: a lidar in an office sees a hundred walls of thousands. A scan that searches the tree
/// finds out anew each time that it need not draw the others.
///
/// Method: walls that share corners are followed to the left and to the right, as seen from the
/// centre c of the box: a chain. A point x is hidden from the disc around the box if
///
///   1. the ray from c through x meets a part of a chain, from P on the right to Q on the left,
///      only at points that are nearer to c than x;
///   2. x is to the left of the lines from all points of the disc past P, and to the right of those
///      past Q;
///   3. the part is outside of the disc, and does not go all around it.
///
/// Proof: let v be a point of the disc. Go from v to x, and on along the ray from c to infinity.
/// The part, with the rays from P and Q to infinity in their directions from c, divides the plane
/// between v and there. The way does not cross the rays: it passes P and Q on the side of c (2).
/// Behind x it does not cross the part (1). So it crosses it before x.
///
/// Near search: directions are divided into buckets. Each has a radius behind which all is hidden,
/// as a depth buffer (Horizon), and the tree is searched as it is for a scan (tree_search.hpp), in
/// rings from near to far: the chain of each wall that is not hidden is drawn. For (2), angles are
/// compared, with those that the lines have in the infinite. Last, the tree is searched once more
/// for all that the whole buffer does not hide.
///
/// Last test: of what is left, most are the far sides of obstacles and walls, just behind the near
/// sides. Each is tested as it is, against the corners of each chain (Hides).

#include "sight/walls_seen_from.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>
#include <utility>

#include "sight/beam_fan.hpp"
#include "sight/tree_search.hpp"

namespace flatland {
namespace {

/// Margins for rounding errors: of angles [rad], of products relative to their size, and the one by
/// which a box is enlarged.
constexpr double kAngleTolerance = 1e-6, kProductTolerance = 1e-9, kLarger = 1.0 + 1e-6;
/// Number of walls that a chain is followed while it turns back.
constexpr size_t kMaxDetour = 3;
/// A chain advances if it turns by more than this [buckets], a margin for rounding errors.
constexpr double kLeastTurn = 1e-6;

/// Most comparisons of walls with chains in a search: 30 ms. An office takes a hundredth of that.
/// Among millions of specks, each is a chain, and a search would take minutes.
constexpr size_t kMostComparisons = 10'000'000;

constexpr int kBuckets = 256;
constexpr float kFirstRing = 1.0f, kNextRing = 1.5f, kLastRing = 64.0f;

/// The directions between the buckets of diamond angles, and the number of buckets before each.
struct Buckets {
  Buckets() {
    for (int i = 0; i < kBuckets; ++i) {
      const double diamond = 4.0 * i / kBuckets - 2.0;
      const double y = std::abs(diamond) > 1.0 ? std::copysign(2.0, diamond) - diamond : diamond;
      const double x = 1.0 - std::abs(diamond);
      directions[i] = 1.0 / std::hypot(x, y) * Vec2{x, y};
      angles[i] = std::atan2(directions[i].y, directions[i].x);
    }
    angles[0] = -M_PI;
    for (int i = 0; i < kBuckets + 2; ++i) before[i] = std::min(i, kBuckets);
  }
  /// Their number counted from -x, with fractions.
  static double Of(Vec2 v) { return (DiamondAngle(v) + 2.0) * (kBuckets / 4.0); }

  std::array<Vec2, kBuckets> directions;
  std::array<double, kBuckets> angles;  // [rad]
  std::array<int, kBuckets + 2> before;
};

bool IsAt(Vec2 a, Vec2 b) { return a.x == b.x && a.y == b.y; }
/// True if a point is to the left of the line from a to b, by more than rounding errors.
bool IsLeftOf(Vec2 a, Vec2 b, Vec2 point) {
  const Vec2 along = b - a, to_point = point - a;
  return Cross(along, to_point) >
         kProductTolerance * ManhattanNorm(along) * ManhattanNorm(to_point);
}
/// The distance of the wall from a to b from the origin.
double DistanceOf(Vec2 a, Vec2 b) {
  const Vec2 along = b - a;
  return LengthOf(a + std::clamp(-Dot(a, along) / Dot(along, along), 0.0, 1.0) * along);
}

class Finder {
 public:
  std::optional<std::vector<uint32_t>> Find(const SegmentTree& walls, const Corners& corners,
                                            const Box& box) {
    walls_ = &walls;
    corners_ = &corners;
    center_ = 0.5 * (box.low + box.high);
    radius_ = 0.5 * kLarger * LengthOf(box.high - box.low);
    lists_.MakeRoomFor(walls);
    horizon_.Begin(kBuckets);
    inverse_.assign(kBuckets, 0.0);
    states_.assign(walls.segment_count(), State::kUnknown);
    chains_.clear();
    vertices_.clear();
    comparisons_ = 0;
    std::vector<uint32_t> found;
    float from = 0.0f;
    for (float to = kFirstRing; from < kLastRing; from = std::exchange(to, kNextRing * to)) {
      found.clear();
      Search(from, to, found);
      for (const uint32_t wall : found) {
        if (states_[wall] == State::kUnknown && !IsHidden(wall)) DrawChainOf(wall);
        if (comparisons_ > kMostComparisons) return std::nullopt;
      }
    }
    found.clear();
    Search(0.0f, std::numeric_limits<float>::infinity(), found);
    if (found.size() * chains_.size() > kMostComparisons) return std::nullopt;
    const auto is_hidden = [this](uint32_t wall) { return IsHidden(wall); };
    found.erase(std::remove_if(found.begin(), found.end(), is_hidden), found.end());
    return found;
  }

 private:
  /// A point of a chain, in the direction between two buckets.
  struct Sample {
    double angle;  // [rad]
    double limit;  // greatest angle of a line from the disc through the point to that [rad]
    double far;    // greatest radius of the chain since the sample before [m]
    double back;   // the same, of the parts that lead back
  };
  /// A corner of a chain where it leads on.
  struct Vertex {
    double place;  // buckets
    Vec2 point;    // relative to the centre [m]
    double back;   // greatest radius of the parts that lead back since the vertex before [m]
  };
  /// The vertices of a chain from right to left, by their numbers.
  struct Chain {
    size_t begin, end;
    double from, to;  // their places, with a margin; from 0 to kBuckets on
    double nearest;   // radius of a vertex [m]
  };
  /// One side of a chain.
  struct Trail {
    std::vector<Sample> samples;
    std::vector<Vertex> vertices;
  };
  enum class State : char { kUnknown, kInChain, kHidden };

  static const Buckets& buckets() {
    static const Buckets buckets;
    return buckets;
  }
  /// The index and the angle [rad] of a direction between two buckets, counted from -x on.
  static int IndexOf(int boundary) { return (boundary % kBuckets + kBuckets) % kBuckets; }
  static double AngleOf(int boundary) {
    const int index = IndexOf(boundary);
    return buckets().angles[index] + 2.0 * M_PI * ((boundary - index) / kBuckets);
  }
  /// Buckets from one direction to another, to the left, less than half a rotation.
  static double Turn(Vec2 from, Vec2 to) {
    const double turn = Buckets::Of(to) - Buckets::Of(from);
    return turn > kBuckets / 2 ? turn - kBuckets : turn < -kBuckets / 2 ? turn + kBuckets : turn;
  }
  /// An end of a wall, as seen from the centre.
  Vec2 PointOf(uint32_t end) const { return Corners::PointOf(walls_->segments(), end) - center_; }

  void Search(float from, float to, std::vector<uint32_t>& found);

  bool IsOutside(Vec2 a, Vec2 b) const { return DistanceOf(a, b) > radius_; }
  /// Continues a chain at the end of a wall: among the walls at the same corner and outside of the
  /// disc, takes the one that turns most to the side (1: left), and goes to its far end. Returns
  /// false if there is none.
  bool Follow(uint32_t* end, double side) const {
    const Vec2 corner = PointOf(*end);
    double most = -kBuckets;
    uint32_t best = 0;
    for (uint32_t each = corners_->Next(*end); each != *end; each = corners_->Next(each)) {
      const Vec2 to = PointOf(Corners::OtherEnd(each));
      const double turn = side * Turn(corner, to);
      if (!(turn > most) || !IsOutside(corner, to)) continue;
      most = turn;
      best = Corners::OtherEnd(each);
    }
    if (most == -kBuckets) return false;
    *end = best;
    return true;
  }
  /// Tangent of an upper bound of asin(radius_ / radius), the angle of a tangent of the disc.
  Sample SampleAt(int boundary, double radius, double far, double back) const {
    const double sine = radius_ / radius;
    const double limit = sine / std::sqrt(1.0 - sine * sine) + kAngleTolerance;
    return {AngleOf(boundary), limit, far, back};
  }
  /// Follows a chain along a wall to its `end` and beyond, to the left (`side` 1) or to the right
  /// (`side` -1), and samples it from a boundary on. A detour is included if the chain advances
  /// after it.
  void Trace(uint32_t end, double side, int boundary, Trail& trail) {
    Vec2 from = PointOf(Corners::OtherEnd(end));
    double place = Buckets::Of(from), farthest = place;
    double far = LengthOf(from), back = 0.0, back_to_vertex = 0.0;
    trail.samples.clear();
    trail.vertices.assign(1, {place, from, 0.0});
    detour_.clear();
    do {
      const Vec2 to = PointOf(end);
      const double most = std::max(LengthOf(from), LengthOf(to));
      place += Turn(from, to);
      const bool leads_on = side * (place - farthest) > kLeastTurn;
      if (!leads_on || !detour_.empty()) {
        back = std::max(back, most);
        back_to_vertex = std::max(back_to_vertex, most);
      }
      detour_.push_back(Corners::WallOf(end));
      for (; side * boundary <= side * place; boundary += static_cast<int>(side)) {
        const Vec2 direction = buckets().directions[IndexOf(boundary)];
        // A wall along the direction gives NaN, which is replaced by a distance at which nothing is
        // hidden.
        const double radius = Cross(from, to) / Cross(direction, to - from);
        const double usable = std::min(most, std::max(radius_, radius));
        trail.samples.push_back(
            SampleAt(boundary, usable, std::max(far, usable), std::exchange(back, 0.0)));
        far = usable;
      }
      far = std::max(far, LengthOf(to));
      from = to;
      if (leads_on) {
        farthest = place;
        trail.vertices.push_back({place, to, std::exchange(back_to_vertex, 0.0)});
        for (const uint32_t each : detour_) states_[each] = State::kInChain;
        detour_.clear();
      }
    } while (detour_.size() <= kMaxDetour && std::abs(place - farthest) < kBuckets / 4 &&
             trail.samples.size() < kBuckets && Follow(&end, side));
  }
  void DrawChainOf(uint32_t wall) {
    uint32_t left = Corners::EndOf(wall), right = Corners::OtherEnd(left);
    if (!IsOutside(PointOf(left), PointOf(right))) return;
    if (Cross(PointOf(left), PointOf(right)) > 0.0) std::swap(left, right);
    states_[wall] = State::kInChain;
    const int first = static_cast<int>(std::ceil(Buckets::Of(PointOf(right))));
    Trace(left, 1.0, first, left_);
    right_.samples.clear();
    right_.vertices.clear();
    if (Follow(&right, -1.0)) Trace(right, -1.0, first - 1, right_);
    Join();
    Draw(first - static_cast<int>(right_.samples.size()));
  }
  /// Makes one chain of the two trails, from right to left: samples to draw, and vertices to keep.
  void Join() {
    std::vector<Sample>&right = right_.samples, &left = left_.samples;
    if (!right.empty() && !left.empty()) {
      left[0].far = std::max(left[0].far, right[0].far);
      left[0].back = std::max(left[0].back, right[0].back);
    }
    for (size_t i = 0; i + 1 < right.size(); ++i) {
      right[i].far = right[i + 1].far;
      right[i].back = right[i + 1].back;
    }
    left.insert(left.begin(), right.rbegin(), right.rend());
    const size_t begin = vertices_.size();
    double back = 0.0, nearest = std::numeric_limits<double>::infinity();
    for (size_t i = right_.vertices.size(); i-- > 1;) {  // the first one is the left trail's, too
      const Vertex& each = right_.vertices[i];
      vertices_.push_back({each.place, each.point, std::exchange(back, each.back)});
    }
    left_.vertices[0].back = back;
    vertices_.insert(vertices_.end(), left_.vertices.begin(), left_.vertices.end());
    if (vertices_.size() < begin + 2) return;  // edge-on
    const double turned = std::floor((vertices_[begin].place - kLeastTurn) / kBuckets) * kBuckets;
    for (size_t i = begin; i < vertices_.size(); ++i) {
      vertices_[i].place -= turned;
      nearest = std::min(nearest, LengthOf(vertices_[i].point));
    }
    chains_.push_back({begin, vertices_.size(), vertices_[begin].place - kLeastTurn,
                       vertices_.back().place + kLeastTurn, nearest});
  }
  /// Draws the chain, with its first sample at a boundary, on all buckets that it hides.
  void Draw(int first) {
    const std::vector<Sample>& chain = left_.samples;
    const int count = static_cast<int>(chain.size());
    for (int k = 0; k + 1 < count; ++k) {
      double farthest = std::max(chain[k + 1].far, chain[k + 1].back);
      int right = k, left = k + 1;
      while (right >= 0 && chain[right].angle + chain[right].limit > chain[k].angle) {
        farthest = std::max(farthest, chain[right--].back);
      }
      while (left < count && chain[left].angle - chain[left].limit < chain[k + 1].angle) {
        if (++left < count) farthest = std::max(farthest, chain[left].back);
      }
      if (right < 0 || left == count || left - right >= kBuckets) continue;
      double& inverse = inverse_[IndexOf(first + k)];
      inverse = std::max(inverse, 1.0 / farthest);
    }
  }

  /// True if a chain hides a wall, or did so.
  bool IsHidden(uint32_t wall) {
    if (states_[wall] == State::kHidden) return true;
    Vec2 right = PointOf(Corners::EndOf(wall));
    Vec2 left = PointOf(Corners::OtherEnd(Corners::EndOf(wall)));
    if (!IsOutside(right, left)) return false;
    if (Turn(right, left) < 0.0) std::swap(right, left);
    const double place = Buckets::Of(right), turn = Turn(right, left);
    const double farthest = std::max(LengthOf(right), LengthOf(left));
    comparisons_ += chains_.size();
    for (Chain& chain : chains_) {
      const double from = place < chain.from ? place + kBuckets : place;
      if (chain.nearest > farthest || from + turn > chain.to) continue;
      const Vertex* const vertices = vertices_.data();
      if (!Hides(vertices + chain.begin, vertices + chain.end, {right, left}, from, from + turn)) {
        continue;
      }
      states_[wall] = State::kHidden;
      std::swap(chain, chains_.front());  // it is likely to hide the next wall, too
      return true;
    }
    return false;
  }
  /// True if a chain hides a wall, from a on the right to b, that is in directions of the chain.
  bool Hides(const Vertex* begin, const Vertex* end, const Segment& wall, double from,
             double to) const {
    const auto [a, b] = wall;
    const auto next = [&](double place) {
      const auto is_before = [](double at, const Vertex& vertex) { return at < vertex.place; };
      return std::clamp(std::upper_bound(begin, end, place, is_before), begin + 1, end - 1);
    };
    // a is in the direction of the part of the chain from i on, b of that up to j.
    const Vertex *i = next(from) - 1, *j = next(to);
    if (IsAt(a, i[1].point) && i + 2 < end) ++i;
    if (IsAt(b, j[-1].point) && j - 2 >= begin) --j;
    const bool begins_there = IsAt(a, i->point), ends_there = IsAt(b, j->point);
    if (j <= i || (j == i + 1 && begins_there && ends_there)) return false;
    // The wall is behind the chain.
    if (!begins_there && !IsLeftOf(i[1].point, i->point, a)) return false;
    if (!ends_there && !IsLeftOf(j->point, j[-1].point, b)) return false;
    double back = 0.0;
    for (const Vertex* k = i + 1; k <= j; ++k) {
      if (k < j && !IsLeftOf(a, b, k->point)) return false;
      back = std::max(back, k->back);
    }
    // All of the disc is to the left of the line from P to each end, and to the right of that from
    // Q. An end at P or Q is seen there, as a corner of the chain.
    const auto is_past = [&](Vec2 point, const Vertex* corner, double side) {
      const double cross = side * Cross(corner->point, point);
      return IsAt(point, corner->point) ||
             cross > kLarger * radius_ * LengthOf(point - corner->point);
    };
    while (!is_past(a, i, 1.0) || !is_past(b, i, 1.0)) {
      if (i == begin) return false;
      back = std::max(back, (i--)->back);
    }
    while (!is_past(a, j, -1.0) || !is_past(b, j, -1.0)) {
      if (++j == end) return false;
      back = std::max(back, j->back);
    }
    return j->place - i->place < kBuckets && DistanceOf(a, b) > kLarger * back;
  }

  const SegmentTree* walls_ = nullptr;
  const Corners* corners_ = nullptr;
  Vec2 center_;
  double radius_ = 0.0;     // of the disc around the box [m]
  AlignedDoubles inverse_;  // of the radius behind which all is hidden, by bucket [1/m]
  Horizon horizon_;
  SearchLists lists_;
  std::vector<State> states_;  // by wall
  std::vector<Chain> chains_;
  std::vector<Vertex> vertices_;  // of all chains
  std::vector<uint32_t> detour_;
  size_t comparisons_ = 0;
  Trail left_, right_;  // of a chain
};

FLATLAND_CLONES void FindUnhiddenWalls(const SegmentTree& walls, const TreeView& tree,
                                       const Hiding& hiding, SearchLists& lists,
                                       std::vector<uint32_t>& found) {
  FindUnhidden(walls, tree, hiding, lists, [&](const int* visible, int count) {
    found.insert(found.end(), visible, visible + count);
  });
}

FLATLAND_CLONES void UpdateHorizon(Horizon& horizon, const double* inverse) {
  horizon.Update(inverse);
}

void Finder::Search(float from, float to, std::vector<uint32_t>& found) {
  UpdateHorizon(horizon_, inverse_.data());
  const TreeView tree(*walls_, center_, Rotation(0.0), kBuckets / 4.0, from, to);
  FindUnhiddenWalls(*walls_, tree, {horizon_, buckets().before.data(), kBuckets}, lists_, found);
}

}  // namespace

Corners::Corners(const std::vector<Segment>& walls) : next_(2 * walls.size()) {
  std::vector<uint32_t> ends(next_.size());
  std::iota(ends.begin(), ends.end(), 0);
  const auto place = [&](uint32_t end) {
    const Vec2 point = PointOf(walls, end);
    return std::pair(point.x, point.y);
  };
  std::sort(ends.begin(), ends.end(), [&](uint32_t a, uint32_t b) { return place(a) < place(b); });
  for (size_t first = 0, i = 0; i < ends.size(); ++i) {
    const bool is_last = i + 1 == ends.size() || place(ends[i + 1]) != place(ends[i]);
    next_[ends[i]] = ends[is_last ? first : i + 1];
    if (is_last) first = i + 1;
  }
}

std::optional<std::vector<uint32_t>> WallsSeenFrom(const SegmentTree& walls, const Corners& corners,
                                                   const Box& box) {
  thread_local Finder finder;  // keeps its memory
  if (walls.segment_count() == 0) return std::vector<uint32_t>();
  return finder.Find(walls, corners, box);
}

}  // namespace flatland
