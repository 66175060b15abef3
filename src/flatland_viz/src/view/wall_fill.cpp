// A horizontal line sweeps over the outlines. Between two heights at which edges begin or end, the
// edges that it meets have the same order from left to right, and every second gap between them is
// inside. Such a gap is a trapezoid, which continues as long as it has the same two edges: a wall
// of an office is one trapezoid.

#include "wall_fill.hpp"

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <unordered_map>
#include <utility>

namespace flatland_viz {
namespace {

struct Edge {
  float x0, y0, x1, y1;  // y0 < y1

  float At(float y) const { return x0 + (x1 - x0) * ((y - y0) / (y1 - y0)); }
};

std::uint64_t Key(const float* point) {
  std::uint32_t bits[2];
  const float values[2] = {point[0] + 0.0f, point[1] + 0.0f};  // -0 is 0
  std::memcpy(bits, values, sizeof bits);
  return std::uint64_t(bits[0]) << 32 | bits[1];
}

/// Flags of the segments that remain when segments with a free end are removed until there are
/// none.
std::vector<bool> Closed(const std::vector<float>& segments) {
  struct Corner {
    std::size_t ends = 0;
    std::size_t segments =
        0;  // their numbers, combined by exclusive or: the last one if it is alone
  };
  const std::size_t count = segments.size() / 4;
  std::unordered_map<std::uint64_t, Corner> corners;
  corners.reserve(count);
  for (std::size_t i = 0; i < count; ++i) {
    for (const std::size_t end : {4 * i, 4 * i + 2}) {
      Corner& corner = corners[Key(&segments[end])];
      ++corner.ends;
      corner.segments ^= i;
    }
  }
  std::vector<bool> is_closed(count, true);
  std::vector<Corner*> free_ends;
  for (auto& [key, corner] : corners) {
    if (corner.ends == 1) free_ends.push_back(&corner);
  }
  while (!free_ends.empty()) {
    const Corner corner = *free_ends.back();
    free_ends.pop_back();
    if (corner.ends != 1) continue;  // both ends of its segment were free
    const std::size_t segment = corner.segments;
    is_closed[segment] = false;
    for (const std::size_t end : {4 * segment, 4 * segment + 2}) {
      Corner& other = corners[Key(&segments[end])];
      --other.ends;
      other.segments ^= segment;
      if (other.ends == 1) free_ends.push_back(&other);
    }
  }
  return is_closed;
}

std::vector<Edge> EdgesOf(const std::vector<float>& segments) {
  const std::vector<bool> is_closed = Closed(segments);
  std::vector<Edge> edges;
  for (std::size_t i = 0; i < is_closed.size(); ++i) {
    const float* s = &segments[4 * i];
    if (!is_closed[i] || s[1] == s[3]) continue;
    edges.push_back(s[1] < s[3] ? Edge{s[0], s[1], s[2], s[3]} : Edge{s[2], s[3], s[0], s[1]});
  }
  std::sort(edges.begin(), edges.end(), [](const Edge& a, const Edge& b) { return a.y0 < b.y0; });
  return edges;
}

}  // namespace

std::vector<float> FillOf(const std::vector<float>& segments) {
  const std::vector<Edge> edges = EdgesOf(segments);
  std::vector<float> heights;
  for (const Edge& edge : edges) heights.insert(heights.end(), {edge.y0, edge.y1});
  std::sort(heights.begin(), heights.end());
  heights.erase(std::unique(heights.begin(), heights.end()), heights.end());

  std::vector<float> corners;
  const auto add = [&](const Edge& left, const Edge& right, float low, float high) {
    const float a = left.At(low), b = right.At(low), c = left.At(high), d = right.At(high);
    corners.insert(corners.end(), {a, low, b, low, d, high, a, low, d, high, c, high});
  };
  using Gap = std::pair<std::size_t, std::size_t>;  // its edges
  std::vector<std::size_t> met;                     // edges, from left to right
  std::vector<std::pair<Gap, float>> gaps, next;  // each with the height at which it began, sorted
  std::size_t begin = 0;                          // of the edges that are not met yet
  for (std::size_t i = 0; i + 1 < heights.size(); ++i) {
    const float low = heights[i], middle = low + (heights[i + 1] - low) / 2;
    met.erase(std::remove_if(met.begin(), met.end(),
                             [&](std::size_t edge) { return edges[edge].y1 <= low; }),
              met.end());
    while (begin < edges.size() && edges[begin].y0 <= low) met.push_back(begin++);
    std::sort(met.begin(), met.end(), [&](std::size_t a, std::size_t b) {
      return edges[a].At(middle) < edges[b].At(middle);
    });
    next.clear();
    for (std::size_t k = 0; k + 1 < met.size(); k += 2) next.push_back({{met[k], met[k + 1]}, low});
    std::sort(next.begin(), next.end());
    auto now = next.begin();
    for (const auto& [gap, since] : gaps) {
      while (now != next.end() && now->first < gap) ++now;
      if (now != next.end() && now->first == gap) {
        now->second = since;
      } else {
        add(edges[gap.first], edges[gap.second], since, low);
      }
    }
    gaps.swap(next);
  }
  if (!heights.empty()) {
    for (const auto& [gap, since] : gaps) {
      add(edges[gap.first], edges[gap.second], since, heights.back());
    }
  }
  return corners;
}

}  // namespace flatland_viz
