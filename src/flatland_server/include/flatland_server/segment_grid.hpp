#pragma once

/// Static walls, indexed once for rays.
///
/// The need: a lidar casts a thousand rays ten times a second at walls that never move, and
/// b2World::RayCast walks a tree of boxes made for things that do. The method: a uniform grid over
/// the walls' bounding box; each cell lists the segments that touch it. A ray visits the cells it
/// crosses in order (Amanatides and Woo, "A Fast Voxel Traversal Algorithm for Ray Tracing", 1987)
/// and stops in the first cell that ends behind a hit. The cell size is such that there are about
/// as many cells as segments. The answers are those of exact geometry; the grid only orders the
/// tests.

#include <cstdint>
#include <vector>

#include "flatland_server/geometry.hpp"

namespace flatland {

class SegmentGrid {
 public:
  explicit SegmentGrid(const std::vector<Segment>& segments);

  /// Distance [m] from `origin` along the unit vector `direction` to the nearest segment that is no
  /// farther than `limit`; +infinity if there is none.
  double Cast(Vec2 origin, Vec2 direction, double limit) const;

  size_t segment_count() const { return walls_.size(); }

 private:
  struct Wall {
    Vec2 a;      // one end
    Vec2 along;  // from there to the other
  };

  int Column(double x) const;
  int Row(double y) const;
  template <class Visit>
  void VisitCells(const Segment& segment, Visit visit) const;

  std::vector<Wall> walls_;
  Vec2 low_;  // corner of the bounding box with the smallest coordinates [m]
  Vec2 high_;
  double cell_ = 1.0;  // side of a cell [m]
  int columns_ = 1;
  int rows_ = 1;
  // The walls of cell c are cell_walls_[cell_begin_[c]] to cell_walls_[cell_begin_[c + 1] - 1].
  std::vector<uint32_t> cell_begin_;
  std::vector<uint32_t> cell_walls_;
};

}  // namespace flatland
