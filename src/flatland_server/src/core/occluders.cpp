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

/// The points of the longest chains; each wall is in one of them.
std::vector<std::vector<Vec2>> FindChains(const std::vector<Segment>& walls) {
  const std::vector<uint32_t> neighbors = FindNeighbors(walls);
  std::vector<bool> is_taken(walls.size(), false);
  std::vector<std::vector<Vec2>> chains;
  for (uint32_t wall = 0; wall < walls.size(); ++wall) {
    if (is_taken[wall]) continue;
    uint32_t first = 2 * wall;
    while (neighbors[first] != kNone && neighbors[first] / 2 != wall) {
      first = Opposite(neighbors[first]);
    }
    std::vector<Vec2>& chain = chains.emplace_back();
    chain.push_back(PointAt(walls, first));
    for (uint32_t end = first; end != kNone && !is_taken[end / 2]; end = neighbors[Opposite(end)]) {
      is_taken[end / 2] = true;
      chain.push_back(PointAt(walls, Opposite(end)));
    }
  }
  return chains;
}

/// Appends the chords over 2, 4, 8 ... walls of a chain.
void AddChords(const std::vector<Vec2>& chain, std::vector<Segment>* lines,
               std::vector<Box>* boxes) {
  for (size_t span = 2; span < chain.size(); span *= 2) {
    for (size_t begin = 0; begin + span < chain.size(); begin += span / 2) {
      const Segment chord{chain[begin], chain[begin + span]};
      Box box;
      for (size_t i = begin; i < begin + span; ++i) box.Add(Segment{chain[i], chain[i + 1]});
      const Vec2 way = chord.b - chord.a;
      const double length = std::sqrt(Dot(way, way));
      if (!(length > 0.0) || length < kMinLength * box.half_perimeter()) continue;
      lines->push_back(chord);
      boxes->push_back(box);
    }
  }
}

/// A tree of the walls and, after them, their chords; null if there are none.
std::unique_ptr<const SegmentTree> MakeTree(const std::vector<Segment>& walls,
                                            std::vector<Box>* chains) {
  if (walls.size() > Occluders::kMaxWalls) return nullptr;
  std::vector<Segment> lines = walls;
  for (const std::vector<Vec2>& chain : FindChains(walls)) AddChords(chain, &lines, chains);
  return std::make_unique<const SegmentTree>(std::move(lines), SegmentTree::Progress(), 0);
}

}  // namespace

Occluders::Occluders(const SegmentTree& walls)
    : wall_count_(walls.segment_count()),
      with_chords_(MakeTree(walls.segments(), &chains_)),
      tree_(with_chords_ == nullptr ? walls : *with_chords_) {}

}  // namespace flatland
