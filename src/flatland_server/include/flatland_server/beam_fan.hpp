#pragma once

/// The directions of a lidar's beams, in its own frame, sorted once so that the beams between two
/// directions are found without trying them all.

#include <array>
#include <vector>

#include "flatland_server/geometry.hpp"

namespace flatland {

/// Orders directions as their angles do, without a trigonometric function: from -2 (-x, where the
/// angle jumps) over -1 (-y), 0 (+x) and 1 (+y) to 2. Not a number for a vector of no length.
inline double DiamondAngle(Vec2 v) {
  const double slant = v.y / (std::abs(v.x) + std::abs(v.y));
  return v.x >= 0.0 ? slant : std::copysign(2.0, v.y) - slant;
}

class BeamFan {
 public:
  /// `count` beams, the first at `angle_min` [rad], each `increment` [rad] further; a negative
  /// increment turns clockwise. Throws std::invalid_argument on a value that is not finite, on no
  /// beams, and on an increment of zero with more than one beam.
  BeamFan(double angle_min, double increment, int count);
  /// Beams along unit vectors, in any order. Throws std::invalid_argument if there are none.
  explicit BeamFan(std::vector<Vec2> directions);

  int size() const { return static_cast<int>(directions_.size()); }
  Vec2 direction(int beam) const { return directions_[beam]; }

  // From here on beams are counted by rank: in the order of their diamond angles. A fan of more
  // than a turn is no special case then, nor is one that turns clockwise.

  /// Ranks are rounded up to a multiple of this where beams are handled several at a time.
  static constexpr int kGroup = 4;
  /// How many ranks there are room for: a multiple of kGroup.
  int padded_size() const { return static_cast<int>(xs_.size()); }
  /// The directions by rank; beyond size() they are zero.
  const double* xs() const { return xs_.data(); }
  const double* ys() const { return ys_.data(); }
  /// The beam of each rank.
  const std::vector<int>& beams() const { return beams_; }
  /// Whether the beams are in the order of their ranks.
  bool is_sorted() const { return is_sorted_; }

  /// Consecutive ranks from `begin` to before `end`.
  struct Run {
    int begin;
    int end;
  };
  /// The directions from one diamond angle counter-clockwise to another, half a turn further at
  /// most; widened by kSlack on both sides, and again within -2 and 2.
  struct Wedge {
    double from;
    double to;
  };
  /// Much more than the rounding of a diamond angle, much less than the angle between beams.
  static constexpr double kSlack = 1e-6;

  /// The beams in a wedge, and perhaps their neighbours: one run, and if it goes round behind, a
  /// second one.
  std::array<Run, 2> BeamsIn(const Wedge& wedge) const {
    const int begin = before_bucket_[Bucket(wedge.from)];
    const int end = before_bucket_[Bucket(wedge.to) + 1];
    if (wedge.from <= wedge.to) return {{{begin, end}, {0, 0}}};
    return {{{begin, size()}, {0, end}}};
  }
  /// The same for two directions.
  std::array<Run, 2> BeamsBetween(Vec2 from, Vec2 to) const {
    const double right = DiamondAngle(from) - kSlack;
    const double left = DiamondAngle(to) + kSlack;
    return BeamsIn({right < -2.0 ? right + 4.0 : right, left > 2.0 ? left - 4.0 : left});
  }

 private:
  void Sort();
  int Bucket(double diamond_angle) const {
    return static_cast<int>((diamond_angle + 2.0) * buckets_per_unit_);
  }

  std::vector<Vec2> directions_;
  std::vector<double> xs_;
  std::vector<double> ys_;
  std::vector<int> beams_;
  bool is_sorted_ = false;
  // Diamond angles are sorted into buckets of equal width; this says how many beams lie before
  // each.
  std::vector<int> before_bucket_;
  double buckets_per_unit_ = 0.0;
};

}  // namespace flatland
