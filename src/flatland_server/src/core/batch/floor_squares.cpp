#include "batch/floor_squares.hpp"

#include <algorithm>
#include <cmath>

namespace flatland {
namespace {

constexpr double kFullTurn = 2.0 * M_PI;

/// A uniformly distributed integer from 0 to limit - 1, for a limit above 0: D. Lemire, "Fast
/// Random Integer Generation in an Interval", ACM Transactions on Modeling and Computer Simulation
/// 29, 2019.
uint32_t DrawBelow(uint32_t limit, const NumberSource& numbers) {
  if (limit == 1) return 0;  // draws nothing
  uint64_t product;
  do {
    product = uint64_t{numbers.next_uint32(numbers.state)} * limit;
  } while (static_cast<uint32_t>(product) < -limit % limit);
  return static_cast<uint32_t>(product >> 32);
}

/// True if a disc overlaps no other one.
bool IsClear(Vec2 middle, double radius, const std::vector<Disc>& others) {
  return std::all_of(others.begin(), others.end(), [&](const Disc& other) {
    const Vec2 way = middle - other.middle;
    const double least = radius + other.radius;  // most are this far apart along one axis
    return std::abs(way.x) > least || std::abs(way.y) > least || std::hypot(way.x, way.y) > least;
  });
}

double DrawHeading(const NumberSource& numbers) { return kFullTurn * numbers.Draw() - M_PI; }

/// Along one axis: the squares, of `count`, that are between a and b or within `reach` of them.
struct Span {
  Span(double a, double b, double reach, double side, int64_t count)
      : begin(Within(std::floor((std::min(a, b) - reach) / side), count)),
        end(Within(std::ceil((std::max(a, b) + reach) / side), count)) {}
  static int64_t Within(double index, int64_t count) {
    return static_cast<int64_t>(std::clamp(index, 0.0, static_cast<double>(count)));
  }

  int64_t begin, end;
};

}  // namespace

void LowerToWalls(const std::vector<Segment>& walls, double reach, Vec2 corner, double side,
                  int64_t rows, int64_t columns, double* squares) {
  for (const Segment& wall : walls) {
    const Vec2 along = wall.b - wall.a, offset = corner - wall.a;
    // Like Python's `**`, which may differ from a product in the last bit.
    const double square = std::pow(along.x, 2.0) + std::pow(along.y, 2.0);
    const Vec2 scaled = square > 0.0 ? Vec2{along.x / square, along.y / square} : Vec2{};
    const Span xs(wall.a.x - corner.x, wall.b.x - corner.x, reach, side, columns);
    const Span ys(wall.a.y - corner.y, wall.b.y - corner.y, reach, side, rows);
    for (int64_t row = ys.begin; row < ys.end; ++row) {
      const double y = (static_cast<double>(row) + 0.5) * side + offset.y;
      double* const numbers = squares + row * columns;
      for (int64_t column = xs.begin; column < xs.end; ++column) {
        const double x = (static_cast<double>(column) + 0.5) * side + offset.x;
        const double part = std::min(std::max(scaled.x * x + scaled.y * y, 0.0), 1.0);
        const Vec2 away{x - part * along.x, y - part * along.y};
        numbers[column] = std::min(numbers[column], away.x * away.x + away.y * away.y);
      }
    }
  }
}

void MarkConnected(const bool* free, int64_t rows, int64_t columns, int64_t start, bool* reached) {
  std::vector<int64_t> part, largest;  // squares that are connected
  const auto reach = [&](int64_t index) {
    if (!free[index] || reached[index]) return;
    reached[index] = true;
    part.push_back(index);
  };
  const auto reach_from = [&](int64_t first) {
    part.clear();
    reach(first);
    for (size_t i = 0; i < part.size(); ++i) {
      const int64_t index = part[i], row = index / columns, column = index % columns;
      if (column > 0) reach(index - 1);
      if (column + 1 < columns) reach(index + 1);
      if (row > 0) reach(index - columns);
      if (row + 1 < rows) reach(index + columns);
    }
  };
  if (start >= 0) return reach_from(start);
  for (int64_t index = 0; index < rows * columns; ++index) {
    if (reached[index]) continue;
    reach_from(index);
    if (part.size() > largest.size()) largest.swap(part);
  }
  std::fill_n(reached, rows * columns, false);
  for (const int64_t index : largest) reached[index] = true;
}

FloorSquares::FloorSquares(const bool* squares, int rows, int columns, Vec2 corner, double side)
    : rows_(rows),
      columns_(columns),
      words_((columns + kWord - 1) / kWord),
      bits_(int64_t{rows} * words_),
      before_{0},
      corner_(corner),
      side_(side) {
  for (int row = 0; row < rows; ++row) {
    uint32_t count = before_.back();
    for (int column = 0; column < columns; ++column) {
      if (!*squares++) continue;
      bits_[int64_t{row} * words_ + column / kWord] |= uint64_t{1} << (column % kWord);
      ++count;
    }
    before_.push_back(count);
  }
}

bool FloorSquares::Contains(Vec2 point) const {
  const double column = std::floor((point.x - corner_.x) / side_);
  const double row = std::floor((point.y - corner_.y) / side_);
  return row >= 0.0 && row < rows_ && column >= 0.0 && column < columns_ &&
         IsOne(static_cast<int>(row), static_cast<int>(column));
}

void FloorSquares::Crop(const Pose& pose, int cells, bool* crop) const {
  const Rotation heading(pose.yaw);
  const Vec2 robot{(pose.x - corner_.x) / side_, (pose.y - corner_.y) / side_};
  const double middle = (cells - 1) / 2.0;
  for (int i = 0; i < cells; ++i) {
    for (int j = 0; j < cells; ++j) {
      const Vec2 at = robot + heading.Apply({i - middle, j - middle});
      *crop++ = at.x >= 0.0 && at.x < columns_ && at.y >= 0.0 && at.y < rows_ &&
                IsOne(static_cast<int>(at.y), static_cast<int>(at.x));
    }
  }
}

Vec2 FloorSquares::Draw(const NumberSource& numbers) const {
  const uint32_t number = DrawBelow(static_cast<uint32_t>(size()), numbers);
  const auto after = std::upper_bound(before_.begin(), before_.end(), number);
  const auto row = after - before_.begin() - 1;
  const uint64_t* word = bits_.data() + row * words_;
  int column = 0;
  uint32_t rest = number - before_[row];
  for (uint32_t count; (count = __builtin_popcountll(*word)) <= rest; ++word) {
    rest -= count;
    column += kWord;
  }
  uint64_t bits = *word;
  for (; rest > 0; --rest) bits &= bits - 1;
  column += __builtin_ctzll(bits);
  const double along_x = numbers.Draw(), along_y = numbers.Draw();
  return {corner_.x + (static_cast<double>(column) + along_x) * side_,
          corner_.y + (static_cast<double>(row) + along_y) * side_};
}

std::vector<std::optional<Pose>> FloorSquares::DrawClear(const NumberSource& numbers,
                                                         std::vector<Disc> others, double radius,
                                                         double distance, int count,
                                                         int tries) const {
  std::vector<std::optional<Pose>> poses(count);
  for (std::optional<Pose>& pose : poses) {
    for (int i = 0; i < tries && !pose; ++i) {
      const Vec2 point = Draw(numbers);
      if (!IsClear(point, distance, others)) continue;
      pose = Pose{point.x, point.y, DrawHeading(numbers)};
      others.push_back({point, radius});
    }
  }
  return poses;
}

std::optional<Ends> FloorSquares::DrawEnds(const NumberSource& numbers,
                                           const EndsSettings& settings, int tries) const {
  const double least = std::pow(settings.least, 2.0), largest = std::pow(settings.largest, 2.0);
  const auto around = [&](Vec2 middle) {  // uniform over the area
    const double distance = std::sqrt(least + numbers.Draw() * (largest - least));
    const double bearing = kFullTurn * numbers.Draw();
    return middle + distance * Vec2{std::cos(bearing), std::sin(bearing)};
  };
  const auto fits = [&](Vec2 point, const std::vector<Disc>& others) {
    return Contains(point) && IsClear(point, settings.radius, others);
  };
  for (int i = 0; i < tries; ++i) {
    Ends ends;
    ends.yaw = DrawHeading(numbers);
    ends.start = settings.start  ? *settings.start
                 : settings.goal ? around(*settings.goal)
                                 : Draw(numbers);
    ends.goal = settings.goal ? *settings.goal : around(ends.start);
    if ((settings.start || fits(ends.start, settings.at_starts)) &&
        (settings.goal || fits(ends.goal, settings.at_goals))) {
      return ends;
    }
  }
  return std::nullopt;
}

}  // namespace flatland
