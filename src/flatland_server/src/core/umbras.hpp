#pragma once

/// The parts of the plane that single occluders hide from every point of a box, for WallSearch.
///
/// Need. Of thousands of walls nearly all are hidden from a cell, most of them by a single wall or
/// chord. To look for it along a line, target by target, takes most of a search.
///
/// Method. A depth buffer for a box instead of a point. An occluder's umbra is what is behind its
/// line, to the left of all lines from the box past its right end, and to the right of those past
/// its left end. It is convex: if it holds the rest of two neighbouring directions from the middle
/// of the box, each from some distance on, it holds all that is between them and farther than both.
/// So each wedge between two directions keeps the nearest distance beyond which all is in one
/// umbra. A target is hidden if it is farther than that in all wedges that it meets. That may be by
/// several umbras side by side.

#include <vector>

#include "flatland_server/beam_fan.hpp"
#include "flatland_server/geometry.hpp"
#include "occluders.hpp"

namespace flatland {

class Umbras {
 public:
  /// None yet. A box has corners apart from each other.
  explicit Umbras(const Box& from);

  void Add(const Occluder& occluder);
  /// True if no line from the box to a wall, or to anything in another box, is free.
  bool Hide(const Segment& wall) const;
  bool Hide(const Box& box) const;

 private:
  /// True if in all wedges from the direction of `right` counter-clockwise to that of `left` the
  /// umbra begins before `inverse(wedge)`, an inverse distance [1/m].
  template <class Inverse>
  bool BeginBefore(Vec2 right, Vec2 left, Inverse inverse) const;

  const Box from_;
  const Vec2 middle_;
  Vec2 corners_[4];              // of the box; like all points here, from its middle [m]
  std::vector<double> inverse_;  // by wedge, from the beam with its rank on: of the distance [1/m]
};

}  // namespace flatland
