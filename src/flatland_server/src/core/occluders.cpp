#include "occluders.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <tuple>
#include <utility>

namespace flatland {

/// A longest chain: its walls, and the points where they begin and the last one ends.
struct Occluders::Walk {
  std::vector<uint32_t> walls;
  std::vector<Vec2> points;
  bool is_closed = false;
};

namespace {

using Walk = Occluders::Walk;

/// A chord is at least as long as this fraction of half the perimeter of its chain's box: others
/// hide little.
constexpr double kMinLength = 0.3;
/// Shorter ones hide next to nothing from a cell [m].
constexpr double kShortest = 0.35;
/// Walls touch if they are nearer to each other than about this fraction of their size, or [m].
constexpr double kTouching = 1e-9;

/// The ends of walls are numbered: those of wall i are 2 i and 2 i + 1.
uint32_t Opposite(uint32_t end) { return end ^ 1u; }
Vec2 PointAt(const std::vector<Segment>& walls, uint32_t end) {
  return end % 2 == 0 ? walls[end / 2].a : walls[end / 2].b;
}

constexpr uint32_t kNone = UINT32_MAX;

/// For each end the end of another wall at the same point, if there is exactly one.
std::vector<uint32_t> FindNeighbors(const std::vector<Segment>& walls) {
  std::vector<uint32_t> ends(2 * walls.size());
  for (uint32_t end = 0; end < ends.size(); ++end) ends[end] = end;
  const auto key = [&](uint32_t end) {
    const Vec2 point = PointAt(walls, end);
    return std::make_tuple(point.x, point.y, end);
  };
  std::sort(ends.begin(), ends.end(), [&](uint32_t a, uint32_t b) { return key(a) < key(b); });
  std::vector<uint32_t> neighbors(ends.size(), kNone);
  for (size_t begin = 0, end = 0; begin < ends.size(); begin = end) {
    const Vec2 point = PointAt(walls, ends[begin]);
    while (end < ends.size() && PointAt(walls, ends[end]).x == point.x &&
           PointAt(walls, ends[end]).y == point.y) {
      ++end;
    }
    if (end - begin != 2 || ends[begin] / 2 == ends[begin + 1] / 2) continue;
    neighbors[ends[begin]] = ends[begin + 1];
    neighbors[ends[begin + 1]] = ends[begin];
  }
  return neighbors;
}

/// The longest chains; each wall is in one of them.
std::vector<Walk> FindChains(const std::vector<Segment>& walls) {
  const std::vector<uint32_t> neighbors = FindNeighbors(walls);
  std::vector<bool> is_taken(walls.size(), false);
  std::vector<Walk> chains;
  for (uint32_t wall = 0; wall < walls.size(); ++wall) {
    if (is_taken[wall]) continue;
    uint32_t first = 2 * wall;
    while (neighbors[first] != kNone && neighbors[first] / 2 != wall) {
      first = Opposite(neighbors[first]);
    }
    Walk& chain = chains.emplace_back();
    chain.points.push_back(PointAt(walls, first));
    for (uint32_t end = first; end != kNone && !is_taken[end / 2]; end = neighbors[Opposite(end)]) {
      is_taken[end / 2] = true;
      chain.walls.push_back(end / 2);
      chain.points.push_back(PointAt(walls, Opposite(end)));
      chain.is_closed = neighbors[Opposite(end)] == first;
    }
  }
  return chains;
}

/// Appends the chords over 2, 4, 8 ... walls of a chain, the first of which has number `first`.
void AddChords(const std::vector<Vec2>& chain, size_t first, std::vector<Segment>* lines,
               std::vector<Occluders::Chain>* chains) {
  for (size_t span = 2; span < chain.size(); span *= 2) {
    for (size_t begin = 0; begin + span < chain.size(); begin += span / 2) {
      const Segment chord{chain[begin], chain[begin + span]};
      Box box;
      for (size_t i = begin; i < begin + span; ++i) box.Add(Segment{chain[i], chain[i + 1]});
      const Vec2 way = chord.b - chord.a;
      const double length = std::sqrt(Dot(way, way));
      if (length < kShortest || length < kMinLength * box.half_perimeter()) continue;
      lines->push_back(chord);
      chains->push_back({box, first + begin, first + begin + span});
    }
  }
}

/// The side of the line from a to b on which a point is: 1 is left, 0 on it or nearly so.
int SideOfLine(Vec2 a, Vec2 b, Vec2 point) {
  const Vec2 along = b - a, way = point - a;
  const double cross = Cross(along, way);
  const double limit = kTouching * (std::abs(along.x * way.y) + std::abs(along.y * way.x)) +
                       kTouching * (std::abs(along.x) + std::abs(along.y));
  return cross > limit ? 1 : cross < -limit ? -1 : 0;
}

/// True if two walls cross or touch, or nearly do. Those with an end in common do if they cover
/// each other.
bool DoCollide(const Segment& first, const Segment& second) {
  const auto are_same = [](Vec2 a, Vec2 b) { return a.x == b.x && a.y == b.y; };
  for (const auto& [end, other] : {std::pair(first.a, first.b), std::pair(first.b, first.a)}) {
    for (const auto& [same, opposite] :
         {std::pair(second.a, second.b), std::pair(second.b, second.a)}) {
      if (!are_same(end, same)) continue;
      return SideOfLine(end, other, opposite) == 0 && Dot(other - end, opposite - end) >= 0.0;
    }
  }
  Box box, other;
  box.Add(first);
  other.Add(second);
  if (box.Distance(other) > kTouching * (1.0 + box.half_perimeter())) return false;
  const int a = SideOfLine(first.a, first.b, second.a), b = SideOfLine(first.a, first.b, second.b);
  const int c = SideOfLine(second.a, second.b, first.a);
  const int d = SideOfLine(second.a, second.b, first.b);
  return a * b <= 0 && c * d <= 0;
}

/// True if no two walls of a closed chain touch, but neighbours at their common end.
bool IsSimple(const SegmentTree& walls, const Walk& chain, const std::vector<uint32_t>& chain_of) {
  if (chain.walls.size() < 3) return false;
  const std::vector<Segment>& all = walls.segments();
  for (const uint32_t wall : chain.walls) {
    Box box;
    box.Add(all[wall]);
    bool is_free = true;
    walls.ForEachLeafAt(box, [&](size_t leaf) {
      is_free = is_free && walls.ForEachWall(leaf, [&](uint32_t other) {
        return other == wall || chain_of[other] != chain_of[wall] ||
               !DoCollide(all[wall], all[other]);
      });
    });
    if (!is_free) return false;
  }
  return true;
}

double AreaOf(const std::vector<Vec2>& outline) {
  double area = 0.0;
  for (size_t i = 0; i + 1 < outline.size(); ++i) {
    area += 0.5 * Cross(outline[i] - outline[0], outline[i + 1] - outline[0]);
  }
  return area;
}

}  // namespace

Occluders::Occluders(const SegmentTree& walls)
    : wall_count_(walls.segment_count()),
      with_chords_(AddChains(walls)),
      tree_(with_chords_ == nullptr ? walls : *with_chords_) {}

/// Returns a tree of the walls and, after them, their chords; null if there are too many.
std::unique_ptr<const SegmentTree> Occluders::AddChains(const SegmentTree& walls) {
  if (wall_count_ > kMaxWalls) return nullptr;
  std::vector<Segment> lines;
  for (uint32_t wall = 0; wall < wall_count_; ++wall) {
    const Vec2 way = walls.segments()[wall].b - walls.segments()[wall].a;
    if (Dot(way, way) < kShortest * kShortest) continue;
    long_.push_back(wall);
    lines.push_back(walls.segments()[wall]);
  }
  const std::vector<Walk> chains = FindChains(walls.segments());
  std::vector<uint32_t> chain_of(wall_count_);
  for (size_t i = 0; i < chains.size(); ++i) {
    for (const uint32_t wall : chains[i].walls) chain_of[wall] = static_cast<uint32_t>(i);
  }
  sides_.resize(wall_count_);
  for (const Walk& chain : chains) {
    AddChords(chain.points, in_order_.size(), &lines, &chains_);
    if (chain.is_closed && IsSimple(walls, chain, chain_of)) AddOutline(chain, walls.segments());
    in_order_.insert(in_order_.end(), chain.walls.begin(), chain.walls.end());
  }
  return std::make_unique<const SegmentTree>(std::move(lines), SegmentTree::Progress(), 0);
}

void Occluders::AddOutline(const Walk& chain, const std::vector<Segment>& walls) {
  const bool is_inside_left = AreaOf(chain.points) > 0.0;
  for (size_t i = 0; i < chain.walls.size(); ++i) {
    const Vec2 a = walls[chain.walls[i]].a;
    const bool is_forward = a.x == chain.points[i].x && a.y == chain.points[i].y;
    sides_[chain.walls[i]] = {static_cast<int32_t>(outlines_.size()), is_forward == is_inside_left};
  }
  outlines_.push_back({in_order_.size(), in_order_.size() + chain.walls.size()});
}

std::vector<bool> Occluders::AreOf(const std::vector<uint32_t>& walls) const {
  std::vector<bool> found(tree_.segment_count(), false);
  if (with_chords_ == nullptr) {
    for (const uint32_t wall : walls) found[wall] = true;
    return found;
  }
  std::vector<bool> is_one(wall_count_, false);
  for (const uint32_t wall : walls) is_one[wall] = true;
  for (size_t i = 0; i < long_.size(); ++i) found[i] = is_one[long_[i]];
  std::vector<uint32_t> count(in_order_.size() + 1, 0);  // of those among the first i in order
  for (size_t i = 0; i < in_order_.size(); ++i) count[i + 1] = count[i] + is_one[in_order_[i]];
  for (size_t i = 0; i < chains_.size(); ++i) {
    found[long_.size() + i] = count[chains_[i].begin] < count[chains_[i].end];
  }
  return found;
}

}  // namespace flatland
