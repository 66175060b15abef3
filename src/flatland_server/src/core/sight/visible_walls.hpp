#pragma once

/// The walls of a layer that can be seen from a place, for lidars.
///
/// The floor is divided into square cells. After a few scans from a cell, the walls that can be
/// seen from any point of it are found once, and later scans draw only these. A wall is left out
/// if it is proven that it is hidden from the whole cell (walls_seen_from.cpp), so a scan is the
/// same with these walls as with all.

#include <array>
#include <atomic>
#include <cstdint>
#include <limits>
#include <memory>
#include <vector>

#include "base/geometry.hpp"
#include "sight/segment_tree.hpp"

namespace flatland {

class Corners;

class VisibleWalls {
 public:
  explicit VisibleWalls(std::vector<Segment> segments, const SegmentTree::Progress& progress = {});
  ~VisibleWalls();
  VisibleWalls(const VisibleWalls&) = delete;
  VisibleWalls& operator=(const VisibleWalls&) = delete;

  /// Returns the object of equal segments, or a new one: all worlds with the same map share it.
  static std::shared_ptr<const VisibleWalls> Share(std::vector<Segment> segments,
                                                   const SegmentTree::Progress& progress = {});

  const SegmentTree& all() const { return all_; }
  /// Indices of walls that include all those that a lidar of a range [m] can see from a point, or
  /// no list (null) if these are not known yet. Valid as long as this object. Writes the address of
  /// what it looks up, for a later call from near there. Several threads may call it at a time.
  WallList From(Vec2 point, double range, const void*& cell) const;

  /// Number of scans from a cell before its walls are found. Finding them takes as long as these
  /// scans.
  static constexpr int kScansBefore = 48;

 private:
  /// Ranges of lidars [m].
  static constexpr std::array<double, 8> kRanges{
      2.0, 3.5, 5.0, 8.0, 10.0, 15.0, 20.0, std::numeric_limits<double>::infinity()};
  struct Cell {
    /// The number of walls that a lidar of each range, or less, can see.
    using Counts = std::array<uint16_t, kRanges.size()>;

    std::atomic<int> scans{0};
    Counts within{};
    std::atomic<const uint32_t*> walls{nullptr};  // the nearest first; null before all is known
  };

  void Find(Cell& cell, const Box& box) const;

  SegmentTree all_;
  std::unique_ptr<const Corners> corners_;
  Vec2 origin_;             // the bottom left corner of the cells [m]
  double cell_size_ = 1.0;  // [m]
  int columns_ = 0;
  int rows_ = 0;
  std::unique_ptr<Cell[]> cells_;
  mutable std::atomic<size_t> found_{0};  // indices in all cells
};

}  // namespace flatland
