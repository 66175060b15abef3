#pragma once

/// The walls of a layer that can be seen from a place, for lidars.
///
/// Need. A lidar in an office sees a hundred walls of thousands. Drawing front to back, DepthBuffer
/// skips most of those that are hidden, but has to find them in each scan again.
///
/// Method. The floor is divided into square cells of a metre, and these into cells of half a metre.
/// For a cell where many scans are made, the walls that can be seen from any point of it are found
/// once, and later scans draw only these: in an office 170, or 115 of half a metre, without a tree
/// (WallList), in a quarter or a fifth of the time. The larger cells need fewer scans before, and
/// serve places next to walls, where the smaller ones are hardly ever entered. A wall is left out
/// if it is proven that all lines from the cell to it are blocked: if a single wall, or a chain of
/// walls (occluders.hpp), crosses them all, or, after the cell or the wall has been halved, walls
/// that do so for each half. To be on the safe side, a wall for which this does not succeed soon
/// counts as seen. So a scan is the same with these walls as with all. Most walls are hidden with
/// the box of the tree that they are in: a depth buffer for the cell shows which (umbras.hpp).
/// Walls that scans from the corners of the cell see are taken at once; those that turn their back
/// on it, and so are hidden by others of their outline, are left out at once.
///
/// A search takes about a millisecond; that for a cell of half a metre a third of it if the walls
/// of the cell of a metre around it are known, as only these and their chains matter. So that
/// no step is late, a scan from a cell that waits for its walls makes a part of the first search
/// that waits (wall_search.hpp). Searches take much memory, so only as many are begun as there are
/// threads. In a batch no step is awaited by itself: its scans make whole searches, so that none
/// has to be drawn without them meanwhile. Batches keep what is known in a file (wall_cache.py).

#include <atomic>
#include <climits>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <memory>
#include <mutex>
#include <vector>

#include "flatland_server/geometry.hpp"
#include "flatland_server/segment_tree.hpp"
#include "flatland_server/wall_list.hpp"

namespace flatland {

class Occluders;
class WallSearch;

class VisibleWalls {
 public:
  explicit VisibleWalls(std::shared_ptr<const SegmentTree> walls);
  ~VisibleWalls();

  /// The visible walls of an equal layer, or new ones: all worlds with the same map share them.
  static std::shared_ptr<const VisibleWalls> Share(std::vector<Segment> segments,
                                                   const SegmentTree::Progress& progress = {});

  const SegmentTree& all() const { return *walls_; }
  const std::shared_ptr<const SegmentTree>& shared() const { return walls_; }
  /// Finds the occluders, in 8 ms for an office; otherwise SeenFrom does so when it first
  /// searches.
  void Prepare() const;
  /// Walls among which are all those that a lidar at a point can see, or null if they are not known
  /// (yet); valid as long as this object. A search looks at about `effort` occluders. Several
  /// threads may call it at a time.
  const WallList* SeenFrom(Vec2 point, int effort = kEffort) const;

  /// Of a part of a search, which takes about 20 us; and of a whole one.
  static constexpr int kEffort = 3000, kWholeSearch = INT_MAX;

  /// The number of cells of a metre; 0 with few walls.
  int cell_count() const { return grids_.empty() ? 0 : grids_[1].columns * grids_[1].rows; }
  /// All that is known, as numbers: for each cell kUnknown, kAllWalls, or the number of its walls
  /// and their indices.
  std::vector<uint32_t> GetKnown() const;
  /// Takes what GetKnown gave for equal walls. Returns false, and takes nothing, if it is something
  /// else.
  bool Take(const std::vector<uint32_t>& known) const;
  /// The number of cells with known walls.
  size_t found_count() const;
  /// How many of them the file of a batch has; -1 before it was read.
  mutable std::atomic<int64_t> filed_count{-1};
  static constexpr uint32_t kUnknown = UINT32_MAX;
  static constexpr uint32_t kAllWalls = UINT32_MAX - 1;  ///< too many can be seen for a list

  /// As many scans are made from a cell of a metre before the search for its walls begins, in
  /// batches half of them, and as many from one of half a metre. In an office about sixty more
  /// complete it.
  static constexpr int kScansBefore = 64;
  static constexpr int kScansBeforeInBatch = 32;
  static constexpr int kScansBeforeHalf = 384;

 private:
  /// The visible walls of a cell: their indices, and how they are drawn.
  struct Found {
    std::vector<uint32_t> indices;
    WallList list;
  };

  struct Cell {
    std::atomic<int> scans{0};
    std::atomic<const Found*> seen{nullptr};  // null before it is known
  };

  struct Grid {
    Grid(const Box& bounds, double cell_size, int scans_before, int scans_before_in_batch);
    /// The index of a point's cell, or -1.
    int CellAt(Vec2 point) const;
    /// A cell's box, a little wider.
    Box BoxOf(int cell) const;

    Vec2 origin;       // the bottom left corner of the cells [m]
    double cell_size;  // [m]
    int scans_before, scans_before_in_batch;
    int columns;
    int rows;
    std::unique_ptr<Cell[]> cells;
  };

  struct Search {
    const Grid* grid;
    int cell;
    std::unique_ptr<WallSearch> search;  // null before its begin
  };

  const WallList* SeenFrom(const Grid& grid, Vec2 point, int effort) const;
  void PrepareLocked() const;
  std::unique_ptr<WallSearch> Begin(const Grid& grid, int cell) const;
  /// Keeps the walls of a cell, or that there are too many.
  void KeepLocked(const Grid& grid, int cell, std::vector<uint32_t> indices) const;
  /// Makes a part of a search, or all of it.
  void SearchOn(int effort) const;

  std::shared_ptr<const SegmentTree> walls_;
  std::vector<Grid> grids_;   // the one with the smaller cells first; none for a few walls
  mutable std::mutex mutex_;  // guards the members below
  mutable std::unique_ptr<const Occluders> occluders_;  // made when they are first needed
  mutable std::deque<Search> waiting_;                  // but those that a thread goes on with
  mutable std::vector<std::unique_ptr<const Found>> found_;
  mutable size_t found_walls_ = 0;  // in all of them
};

/// The indices in segments() of those walls of a tree that can be seen from a point of a box, and
/// perhaps of more, in the order of the leaves.
std::vector<uint32_t> WallsSeenFrom(const SegmentTree& walls, const Box& box);
/// The same, where what can hide them is known already.
std::vector<uint32_t> WallsSeenFrom(const SegmentTree& walls, const Occluders& occluders,
                                    const Box& box);

}  // namespace flatland
