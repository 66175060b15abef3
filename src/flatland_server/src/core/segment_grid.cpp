#include "flatland_server/segment_grid.hpp"

#include <algorithm>
#include <limits>

namespace flatland {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
/// Walls are filed this much wider than they are [m], so that rounding never hides one behind the
/// border of two cells.
constexpr double kMargin = 1e-6;
constexpr int kMostCellsPerSide = 4096;
/// How far past its ends a wall still stops a ray, as a fraction of its length: two walls that
/// share a corner leave no gap between them.
constexpr double kEndTolerance = 1e-9;

/// Distance from `origin` along `direction` to the line a + s * along with 0 <= s <= 1.
double CastAtWall(Vec2 origin, Vec2 direction, Vec2 a, Vec2 along) {
  const double denominator = Cross(direction, along);
  if (denominator == 0.0) return kInfinity;  // parallel: the walls beside it stop the ray
  const Vec2 to_a = a - origin;
  const double s = Cross(to_a, direction) / denominator;
  if (s < -kEndTolerance || s > 1.0 + kEndTolerance) return kInfinity;
  const double distance = Cross(to_a, along) / denominator;
  return distance >= 0.0 ? distance : kInfinity;
}

}  // namespace

SegmentGrid::SegmentGrid(const std::vector<Segment>& segments) {
  low_ = {kInfinity, kInfinity};
  high_ = {-kInfinity, -kInfinity};
  walls_.reserve(segments.size());
  for (const Segment& segment : segments) {
    walls_.push_back({segment.a, segment.b - segment.a});
    for (const Vec2& end : {segment.a, segment.b}) {
      low_ = {std::min(low_.x, end.x), std::min(low_.y, end.y)};
      high_ = {std::max(high_.x, end.x), std::max(high_.y, end.y)};
    }
  }
  if (walls_.empty()) low_ = high_ = {0.0, 0.0};
  low_ = low_ - Vec2{kMargin, kMargin};
  high_ = high_ + Vec2{kMargin, kMargin};

  const Vec2 size = high_ - low_;
  const double per_wall = size.x * size.y / std::max<size_t>(1, walls_.size());
  cell_ = std::max(std::sqrt(per_wall), std::max(size.x, size.y) / kMostCellsPerSide);
  columns_ = std::max(1, static_cast<int>(std::ceil(size.x / cell_)));
  rows_ = std::max(1, static_cast<int>(std::ceil(size.y / cell_)));

  // Two passes, count and fill, leave all lists in one array.
  cell_begin_.assign(static_cast<size_t>(columns_) * rows_ + 1, 0);
  for (const Segment& segment : segments) {
    VisitCells(segment, [&](size_t cell) { ++cell_begin_[cell + 1]; });
  }
  for (size_t cell = 1; cell < cell_begin_.size(); ++cell) {
    cell_begin_[cell] += cell_begin_[cell - 1];
  }
  cell_walls_.resize(cell_begin_.back());
  std::vector<uint32_t> next(cell_begin_.begin(), cell_begin_.end() - 1);
  for (uint32_t wall = 0; wall < segments.size(); ++wall) {
    VisitCells(segments[wall], [&](size_t cell) { cell_walls_[next[cell]++] = wall; });
  }
}

int SegmentGrid::Column(double x) const {
  return std::clamp(static_cast<int>(std::floor((x - low_.x) / cell_)), 0, columns_ - 1);
}

int SegmentGrid::Row(double y) const {
  return std::clamp(static_cast<int>(std::floor((y - low_.y) / cell_)), 0, rows_ - 1);
}

/// Row by row: the part of the segment within a row of cells spans some of its columns.
template <class Visit>
void SegmentGrid::VisitCells(const Segment& segment, Visit visit) const {
  const Vec2 lower = segment.a.y <= segment.b.y ? segment.a : segment.b;
  const Vec2 upper = segment.a.y <= segment.b.y ? segment.b : segment.a;
  const double rise = upper.y - lower.y;
  const double slope = rise > kMargin ? (upper.x - lower.x) / rise : 0.0;
  const int last_row = Row(upper.y + kMargin);
  for (int row = Row(lower.y - kMargin); row <= last_row; ++row) {
    double x0 = lower.x;
    double x1 = upper.x;
    if (rise > kMargin) {
      const double bottom = low_.y + row * cell_ - kMargin;
      const double top = low_.y + (row + 1) * cell_ + kMargin;
      x0 = lower.x + slope * std::clamp(bottom - lower.y, 0.0, rise);
      x1 = lower.x + slope * std::clamp(top - lower.y, 0.0, rise);
    }
    const int last_column = Column(std::max(x0, x1) + kMargin);
    for (int column = Column(std::min(x0, x1) - kMargin); column <= last_column; ++column) {
      visit(static_cast<size_t>(row) * columns_ + column);
    }
  }
}

double SegmentGrid::Cast(Vec2 origin, Vec2 direction, double limit) const {
  // The part of the ray within the grid, [enter, leave].
  const Vec2 inverse{1.0 / direction.x, 1.0 / direction.y};
  double enter = 0.0;
  double leave = limit;
  const auto clip = [&](double from, double low, double high, double along, double inverse_along) {
    if (along == 0.0) return low <= from && from <= high;
    const double at_low = (low - from) * inverse_along;
    const double at_high = (high - from) * inverse_along;
    enter = std::max(enter, std::min(at_low, at_high));
    leave = std::min(leave, std::max(at_low, at_high));
    return enter <= leave;
  };
  if (!clip(origin.x, low_.x, high_.x, direction.x, inverse.x) ||
      !clip(origin.y, low_.y, high_.y, direction.y, inverse.y)) {
    return kInfinity;
  }

  int column = Column(origin.x + direction.x * enter);
  int row = Row(origin.y + direction.y * enter);
  const int column_step = direction.x > 0.0 ? 1 : -1;
  const int row_step = direction.y > 0.0 ? 1 : -1;
  // Distance along the ray at which it leaves the cell through a side, and from one such side to
  // the next.
  const auto first_side = [&](double from, double low, int cell, double along,
                              double inverse_along) {
    if (along == 0.0) return kInfinity;
    return (low + (cell + (along > 0.0 ? 1 : 0)) * cell_ - from) * inverse_along;
  };
  double to_column_side = first_side(origin.x, low_.x, column, direction.x, inverse.x);
  double to_row_side = first_side(origin.y, low_.y, row, direction.y, inverse.y);
  const double per_column = std::abs(inverse.x) * cell_;
  const double per_row = std::abs(inverse.y) * cell_;

  double nearest = kInfinity;
  while (true) {
    const size_t cell = static_cast<size_t>(row) * columns_ + column;
    for (uint32_t i = cell_begin_[cell]; i < cell_begin_[cell + 1]; ++i) {
      const Wall& wall = walls_[cell_walls_[i]];
      nearest = std::min(nearest, CastAtWall(origin, direction, wall.a, wall.along));
    }
    const double cell_end = std::min(to_column_side, to_row_side);
    if (nearest <= cell_end || cell_end >= leave) break;
    if (to_column_side < to_row_side) {
      column += column_step;
      if (column < 0 || column >= columns_) break;
      to_column_side += per_column;
    } else {
      row += row_step;
      if (row < 0 || row >= rows_) break;
      to_row_side += per_row;
    }
  }
  return nearest <= limit ? nearest : kInfinity;
}

}  // namespace flatland
