#pragma once

/// For depth_buffer.cpp: how far the farthest of any run of beams ends, without looking at each.
///
/// Row k of a table has the least of each 2^k consecutive beams, so any run is covered by two
/// entries of a row (a sparse table: Bender and Farach-Colton, "The LCA Problem Revisited", 2000).

#include <algorithm>
#include <limits>
#include <vector>

#include "sight/beam_fan.hpp"
#include "sight/doubles.hpp"

namespace flatland {

class Horizon {
 public:
  /// Prepares for a number of beams.
  void Begin(int beams) {
    if (beams == beams_) return;
    beams_ = beams;
    stride_ = (beams + kEight - 1) / kEight * kEight + kEight;
    rows_.assign(1, 0);
    seconds_.assign(1, 0);
    levels_ = 1;
    for (int length = 1; length <= beams; ++length) {
      if (length == 1 << levels_) ++levels_;
      rows_.push_back((levels_ - 1) * stride_);
      seconds_.push_back(length - (1 << (levels_ - 1)));
    }
    // For a run without beams, one more row.
    rows_[0] = levels_ * stride_;
    values_.assign((levels_ + 1) * stride_, std::numeric_limits<float>::infinity());
  }

  /// Takes the inverse distances at which the beams end now.
  FLATLAND_INLINE void Update(const double* inverse) {
    float* row = values_.data();
    for (int i = 0; i < beams_; i += kGroup) {
      const Doubles each = Load(inverse + i);
      Store(ToFloats(each * each), row + i);
    }
    for (int level = 1; level < levels_; ++level, row += stride_) {
      const int half = 1 << (level - 1);
      for (int i = 0; i + 2 * half <= beams_; i += kEight) {
        Store(Min(Load(row + i), Load(row + i + half)), row + stride_ + i);
      }
    }
  }

  /// The least square inverse distance of the beams from `begin` to before `end`, infinite if there
  /// are none; in single precision.
  FLATLAND_INLINE float Least(int begin, int end) const {
    const float* const row = values_.data() + rows_[end - begin] + begin;
    return std::min(row[0], row[seconds_[end - begin]]);
  }

 private:
  int beams_ = 0;
  int stride_ = 0;
  int levels_ = 0;
  // By the length of a run: where its row begins, and how far apart its entries are.
  std::vector<int> rows_, seconds_;
  std::vector<float, AlignedAllocator<float>> values_;
};

}  // namespace flatland
