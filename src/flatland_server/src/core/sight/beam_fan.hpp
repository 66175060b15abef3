#pragma once

/// The directions of a lidar's beams, in its own frame. They are sorted once, so that the beams
/// between two directions are found by looking them up in a table.

#include <array>
#include <cstddef>
#include <new>
#include <vector>

#include "base/geometry.hpp"

namespace flatland {

/// A measure of direction that grows with the angle, without a trigonometric function: -2 at -x,
/// just past -pi; -1 at -y; 0 at +x; 1 at +y; 2 at -x. NaN for the zero vector.
inline double DiamondAngle(Vec2 v) {
  const double slant = v.y / (std::abs(v.x) + std::abs(v.y));
  return v.x >= 0.0 ? slant : std::copysign(2.0, v.y) - slant;
}

/// Allocates arrays that begin at a cache line, so that no group of beams is in two lines.
template <class T>
struct AlignedAllocator {
  using value_type = T;
  static constexpr std::align_val_t kAlignment{64};

  AlignedAllocator() = default;
  template <class U>
  AlignedAllocator(const AlignedAllocator<U>&) {}
  T* allocate(size_t count) {
    return static_cast<T*>(::operator new(count * sizeof(T), kAlignment));
  }
  void deallocate(T* data, size_t) { ::operator delete(data, kAlignment); }
  bool operator==(const AlignedAllocator&) const { return true; }
  bool operator!=(const AlignedAllocator&) const { return false; }
};
using AlignedDoubles = std::vector<double, AlignedAllocator<double>>;

class BeamFan {
 public:
  /// `count` beams, the first at `angle_min` [rad], each `increment` [rad] further
  /// counter-clockwise, or clockwise if negative. Throws std::invalid_argument if a value is not
  /// finite, if there are no beams, and if there are several and the increment is zero.
  BeamFan(double angle_min, double increment, int count);
  /// Beams along these unit vectors, in any order. Throws std::invalid_argument if there are none.
  explicit BeamFan(std::vector<Vec2> directions);

  int size() const { return static_cast<int>(directions_.size()); }
  Vec2 direction(int beam) const { return directions_[beam]; }

  // From here on beams are numbered by rank: in the order of their diamond angles. So a fan that
  // spans more than a full rotation, or goes clockwise, is no special case.

  /// The number of beams that are computed at a time.
  static constexpr int kGroup = 4;
  /// size(), rounded up to a multiple of kGroup, and two groups more.
  int padded_size() const { return static_cast<int>(xs_.size()); }
  /// Directions by rank, padded with zeros to padded_size().
  const double* xs() const { return xs_.data(); }
  const double* ys() const { return ys_.data(); }
  /// Index of the beam of each rank.
  const std::vector<int>& beams() const { return beams_; }
  /// True if each beam's index is its rank.
  bool is_sorted() const { return is_sorted_; }

  /// Consecutive ranks from `begin` to before `end`.
  struct Run {
    int begin;
    int end;
  };
  /// The directions from one diamond angle counter-clockwise to another, by half a rotation at
  /// most. Both are within [-2, 2], and moved apart by kMargin.
  struct Wedge {
    double from;
    double to;
  };
  /// Much more than the rounding error of a diamond angle, much less than the angle between beams.
  static constexpr double kMargin = 1e-6;

  /// The beams in a wedge, and perhaps their neighbours: one run, and a second one if the wedge
  /// contains -x. The other run is empty.
  std::array<Run, 2> BeamsIn(const Wedge& wedge) const {
    return BeamsIn(Bucket(wedge.from), Bucket(wedge.to), wedge.from > wedge.to);
  }
  /// The same by the buckets of its two directions; `wraps` if the wedge contains -x.
  std::array<Run, 2> BeamsIn(int from, int to, bool wraps) const {
    const int begin = before_bucket_[from];
    const int end = before_bucket_[to + 1];
    if (!wraps) return {{{begin, end}, {0, 0}}};
    return {{{begin, size()}, {0, end}}};
  }
  /// For each bucket, the number of beams in the buckets before it.
  const int* before_buckets() const { return before_bucket_.data(); }
  /// The bucket of a diamond angle is the whole part of (angle + 2) * buckets_per_unit().
  double buckets_per_unit() const { return buckets_per_unit_; }
  /// The same for the directions from one vector counter-clockwise to another.
  std::array<Run, 2> BeamsBetween(Vec2 from, Vec2 to) const {
    const double right = DiamondAngle(from) - kMargin;
    const double left = DiamondAngle(to) + kMargin;
    return BeamsIn({right < -2.0 ? right + 4.0 : right, left > 2.0 ? left - 4.0 : left});
  }

 private:
  void Sort();
  int Bucket(double diamond_angle) const {
    return static_cast<int>((diamond_angle + 2.0) * buckets_per_unit_);
  }

  std::vector<Vec2> directions_;
  AlignedDoubles xs_;
  AlignedDoubles ys_;
  std::vector<int> beams_;
  bool is_sorted_ = false;
  // The range of diamond angles is divided into buckets of equal width. For each bucket, the number
  // of beams in the buckets before it.
  std::vector<int> before_bucket_;
  double buckets_per_unit_ = 0.0;
};

}  // namespace flatland
