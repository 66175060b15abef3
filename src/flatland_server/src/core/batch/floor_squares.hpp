#pragma once

/// A floor divided into squares: how far walls are, and random places where something may stand.
///
/// The random numbers are the caller's, from a generator of NumPy, and are drawn as NumPy's own
/// functions draw them: `integers` for the square, then `random` for the place in it.

#include <cstdint>
#include <optional>
#include <vector>

#include "base/geometry.hpp"

namespace flatland {

/// Updates `squares` (`rows` x `columns`), which has the least squared distance [m^2] from a wall
/// found so far for the middle of each square, with more walls. For each wall this covers the
/// squares within `reach` [m] of its bounding rectangle, and perhaps some more. `corner`: of the
/// first square [m]; `side`: of a square [m].
void LowerToWalls(const std::vector<Segment>& walls, double reach, Vec2 corner, double side,
                  int64_t rows, int64_t columns, double* squares);

/// Marks in `reached` the free squares that are connected with square `start` through shared sides;
/// none if `start` is not free. If `start` is negative, marks the largest connected part. `reached`
/// must be false everywhere before the call. Both arrays are `rows` x `columns`.
void MarkConnected(const bool* free, int64_t rows, int64_t columns, int64_t start, bool* reached);

/// A generator of random numbers: NumPy's bitgen_t.
struct NumberSource {
  /// From 0 to below 1.
  double Draw() const { return next_double(state); }

  void* state;
  uint64_t (*next_uint64)(void*);
  uint32_t (*next_uint32)(void*);
  double (*next_double)(void*);
  uint64_t (*next_raw)(void*);
};

/// A place that is taken [m].
struct Disc {
  Vec2 middle;
  double radius;
};

/// Where a robot begins, and where it is to go.
struct Ends {
  double yaw;        // [rad]
  Vec2 start, goal;  // [m]
};

/// Settings for drawing a start and a goal.
struct EndsSettings {
  std::optional<Vec2> start, goal;        ///< not drawn if given [m]
  double least, largest;                  ///< distance between start and goal [m]
  double radius;                          ///< of the robot [m]
  std::vector<Disc> at_starts, at_goals;  ///< discs that the robot must not overlap there
};

class FloorSquares {
 public:
  /// The squares for which `squares` (`rows` x `columns`) is true. `corner`: of the first one [m];
  /// `side`: of a square [m].
  FloorSquares(const bool* squares, int rows, int columns, Vec2 corner, double side);

  size_t size() const { return before_.back(); }
  bool Contains(Vec2 point) const;
  /// Writes a crop of `cells` x `cells` squares of the same size, centred at `pose` and turned with
  /// it: true if the middle of a square is in one of these squares. Rows go from behind to ahead,
  /// each from right to left.
  void Crop(const Pose& pose, int cells, bool* crop) const;
  /// A uniformly distributed point in the squares. There must be at least one square.
  Vec2 Draw(const NumberSource& numbers) const;
  /// Draws poses for `count` discs of a radius [m], one after the other. A disc gets the first of
  /// at most `tries` points that is farther than `distance` [m] from the edges of `others` and of
  /// the discs before it, or no pose.
  std::vector<std::optional<Pose>> DrawClear(const NumberSource& numbers, std::vector<Disc> others,
                                             double radius, double distance, int count,
                                             int tries) const;
  /// Draws a start and a goal up to `tries` times. Returns the first two that are in these squares,
  /// at the required distance and clear of the other discs, or none. A given start or goal is not
  /// checked.
  std::optional<Ends> DrawEnds(const NumberSource& numbers, const EndsSettings& settings,
                               int tries) const;

 private:
  static constexpr int kWord = 64;  // bits

  bool IsOne(int row, int column) const {
    return (bits_[int64_t{row} * words_ + column / kWord] >> (column % kWord) & 1) != 0;
  }

  int rows_, columns_;
  int words_;                     // of a row
  std::vector<uint64_t> bits_;    // one bit a square, since a map may have many floors
  std::vector<uint32_t> before_;  // the number of squares before each row, and last of all squares
  Vec2 corner_;
  double side_;
};

}  // namespace flatland
