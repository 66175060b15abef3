#include "occluders.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <tuple>

namespace flatland {
namespace {

/// A chord is at least as long as this fraction of half the perimeter of its chain's box: others
/// hide little.
constexpr double kMinLength = 0.3;

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

/// A longest chain: its walls, and the points where they begin and the last one ends.
struct Walk {
  std::vector<uint32_t> walls;
  std::vector<Vec2> points;
};

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
      if (!(length > 0.0) || length < kMinLength * box.half_perimeter()) continue;
      lines->push_back(chord);
      chains->push_back({box, first + begin, first + begin + span});
    }
  }
}

/// A tree of the walls and, after them, their chords; null if there are none.
std::unique_ptr<const SegmentTree> MakeTree(const std::vector<Segment>& walls,
                                            std::vector<Occluders::Chain>* chains,
                                            std::vector<uint32_t>* in_order) {
  if (walls.size() > Occluders::kMaxWalls) return nullptr;
  std::vector<Segment> lines = walls;
  for (const Walk& chain : FindChains(walls)) {
    AddChords(chain.points, in_order->size(), &lines, chains);
    in_order->insert(in_order->end(), chain.walls.begin(), chain.walls.end());
  }
  return std::make_unique<const SegmentTree>(std::move(lines), SegmentTree::Progress(), 0);
}

}  // namespace

Occluders::Occluders(const SegmentTree& walls)
    : wall_count_(walls.segment_count()),
      with_chords_(MakeTree(walls.segments(), &chains_, &in_order_)),
      tree_(with_chords_ == nullptr ? walls : *with_chords_) {}

std::vector<bool> Occluders::AreOf(const std::vector<uint32_t>& walls) const {
  std::vector<bool> found(tree_.segment_count(), false);
  for (const uint32_t wall : walls) found[wall] = true;
  std::vector<uint32_t> count(in_order_.size() + 1, 0);  // of those among the first i in order
  for (size_t i = 0; i < in_order_.size(); ++i) count[i + 1] = count[i] + found[in_order_[i]];
  for (size_t i = 0; i < chains_.size(); ++i) {
    found[wall_count_ + i] = count[chains_[i].begin] < count[chains_[i].end];
  }
  return found;
}

}  // namespace flatland
