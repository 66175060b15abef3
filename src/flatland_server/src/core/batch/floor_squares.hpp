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

/// Lowers numbers of squares, rows of `columns` each, to the squared distances [m^2] of their
/// middles from walls; only near the walls, within `reach` [m] of the rectangles around them at
/// least. `corner`: of the first square [m]; `side`: of a square [m].
void LowerToWalls(const std::vector<Segment>& walls, double reach, Vec2 corner, double side,
                  int64_t rows, int64_t columns, double* squares);

/// Marks those free squares that are connected with one through shared sides: none if it is not
/// free; or, if `start` is negative, the largest part that is connected. `reached` is false
/// everywhere at first. All are `rows` x `columns`.
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

/// What ends are drawn from.
struct EndsSettings {
  std::optional<Vec2> start, goal;        ///< those that are given
  double least, largest;                  ///< distance of the two [m]
  double radius;                          ///< of the robot [m]
  std::vector<Disc> at_starts, at_goals;  ///< that it must not overlap there
};

class FloorSquares {
 public:
  /// Those of `rows` x `columns` squares that are true. `corner`: of the first one [m]; `side`: of
  /// a square [m].
  FloorSquares(const bool* squares, int rows, int columns, Vec2 corner, double side);

  size_t size() const { return before_.back(); }
  bool Contains(Vec2 point) const;
  /// Whether the middles of `cells` x `cells` squares of the same size about a pose, in its frame,
  /// are in one of these: row by row from behind, each from right to left.
  void Crop(const Pose& pose, int cells, bool* crop) const;
  /// A point in one of the squares, of which there must be one.
  Vec2 Draw(const NumberSource& numbers) const;
  /// Poses of `count` discs of a radius [m], drawn one after the other: the first of some points at
  /// which it is farther than `distance` [m] from the edges of others, and of those before it; none
  /// after all `tries`.
  std::vector<std::optional<Pose>> DrawClear(const NumberSource& numbers, std::vector<Disc> others,
                                             double radius, double distance, int count,
                                             int tries) const;
  /// The first of some drawn ends that are in these squares, as far apart as they should be, and
  /// clear of others; none after all `tries`. Given ones are not checked.
  std::optional<Ends> DrawEnds(const NumberSource& numbers, const EndsSettings& settings,
                               int tries) const;

 private:
  static constexpr int kWord = 64;  // bits

  bool IsOne(int row, int column) const {
    return (bits_[int64_t{row} * words_ + column / kWord] >> (column % kWord) & 1) != 0;
  }

  int rows_, columns_;
  int words_;                     // of a row
  std::vector<uint64_t> bits_;    // a map may have many floors: a bit a square
  std::vector<uint32_t> before_;  // the number of squares before each row, and of all
  Vec2 corner_;
  double side_;
};

}  // namespace flatland
