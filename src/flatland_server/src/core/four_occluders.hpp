#pragma once

/// For WallSearch: which of many occluders block sight lines, computed four at a time
/// (doubles.hpp).

#include <cstddef>
#include <cstdint>
#include <vector>

#include "flatland_server/beam_fan.hpp"
#include "occluders.hpp"
#include "sight_lines.hpp"

namespace flatland {

/// Four occluders, as a structure of arrays. Unused places are NaN, so that no line meets them.
struct FourOccluders {
  FourOccluders();
  void Set(int place, const Occluder& occluder);

  double ax[BeamFan::kGroup], ay[BeamFan::kGroup], bx[BeamFan::kGroup], by[BeamFan::kGroup];
  double past_ends[BeamFan::kGroup];  // part of their length by which they count as longer
  const Box* chains[BeamFan::kGroup];
};

/// Four boxes, in the same way.
struct FourBoxes {
  FourBoxes();
  void Set(int place, const Box& box);

  double x[BeamFan::kGroup], y[BeamFan::kGroup];            // of the middles
  double half_x[BeamFan::kGroup], half_y[BeamFan::kGroup];  // half the sizes
};

class OccluderField {
 public:
  /// Some of four occluders.
  struct Some {
    uint32_t four;
    uint32_t places;  // bits
  };

  /// Neighbours should be added one after the other.
  void Add(const Occluder& occluder);
  /// The number of fours.
  size_t size() const { return fours_.size(); }

  /// True if a single occluder blocks all lines.
  bool Block(const SightLines& lines);
  /// Adds those that a shaft meets, if they block the lines that they meet.
  void Collect(const Shaft& shaft, const SightLines& lines, std::vector<Some>* found) const;
  /// Adds those of a list's rest, from `begin` on, that a shaft meets.
  void Narrow(const Shaft& shaft, size_t begin, std::vector<Some>* some) const;
  /// Whether one of a list's part crosses all lines, or else one crosses the middle line.
  enum class Crossed { kNone, kMiddle, kAll };
  Crossed Cross(const SightLines& lines, const std::vector<Some>& some, size_t begin,
                size_t end) const;

 private:
  static constexpr size_t kRecent = 4;

  std::vector<FourOccluders> fours_;
  int used_ = BeamFan::kGroup;  // places of the last four
  Box box_;                     // around it
  std::vector<FourBoxes> boxes_;
  std::vector<uint32_t> recent_;  // fours with one that has blocked others, the last one first
};

}  // namespace flatland
