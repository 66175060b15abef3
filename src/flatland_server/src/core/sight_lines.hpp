#pragma once

/// For WallSearch: the lines from a box to a wall.

#include <array>

#include "flatland_server/geometry.hpp"
#include "flatland_server/segment_tree.hpp"
#include "occluders.hpp"

namespace flatland {

inline Vec2 Middle(const Box& box) { return 0.5 * (box.low + box.high); }
inline Vec2 Middle(const Segment& segment) { return 0.5 * (segment.a + segment.b); }
inline std::array<Vec2, 4> CornersOf(const Box& box) {
  return {box.low, {box.high.x, box.low.y}, box.high, {box.low.x, box.high.y}};
}
inline Box BoxOf(const Segment& segment) {
  Box box;
  box.Add(segment);
  return box;
}

/// The lines from all points of a box to all points of a wall, or of a part of one.
struct SightLines {
  SightLines(const Box& from, const Segment& to)
      : from(from), to(to), bounds(BoxOf(to)), corners(CornersOf(from)) {}

  bool HaveLength() const { return !bounds.Meets(from); }
  /// True if an occluder blocks those that meet it: a wall does, a chord those that begin and end
  /// outside of its chain's box.
  bool AreBlockedAt(const Box* chain) const {
    return chain == nullptr || !(chain->Meets(from) || chain->Meets(bounds));
  }
  /// In two parts: those from each half of the box, or to each half of the wall, if that is larger.
  std::array<SightLines, 2> Halves() const;

  Box from;
  Segment to;
  Box bounds;                   // of `to`
  std::array<Vec2, 4> corners;  // of `from`
};

/// All points of sight lines, and perhaps more: what lies between the two lines that touch the box
/// and the wall from the left and from the right.
struct Shaft {
  /// All points p with Dot(normal, p) <= limit.
  struct Side {
    Vec2 normal;
    double limit;
  };

  explicit Shaft(const SightLines& lines);

  Box bounds;
  std::array<Side, 2> sides;
};

}  // namespace flatland
