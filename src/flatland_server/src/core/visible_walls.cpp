#include "flatland_server/visible_walls.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <unordered_map>

namespace flatland {
namespace {

constexpr double kCellSize = 0.5;  // [m]
constexpr double kMaxCells = 262144;
/// With fewer walls, drawing them all is as fast.
constexpr size_t kMinWalls = 64;
/// Of all cells together: 8 bytes each.
constexpr size_t kMaxFoundWalls = 4'000'000;
/// Cells are made wider by this, for rounding errors [m].
constexpr double kMargin = 1e-6;
/// A wall reaches past its ends by this fraction of its length, as it does for DepthBuffer.
constexpr double kEndTolerance = 1e-9;
/// How often cells and targets are halved, and lines are followed, before a wall counts as seen.
constexpr int kMaxDepth = 10;
constexpr int kMaxLines = 48;
constexpr int kMaxLinesToBox = 1;

Vec2 Middle(const Box& box) { return 0.5 * (box.low + box.high); }
Box BoxOf(const Segment& segment) {
  Box box;
  box.Add(segment);
  return box;
}
std::array<Vec2, 4> CornersOf(const Box& box) {
  return {box.low, {box.high.x, box.low.y}, box.high, {box.low.x, box.high.y}};
}
bool AreApart(const Box& a, const Box& b) {
  return a.low.x > b.high.x || b.low.x > a.high.x || a.low.y > b.high.y || b.low.y > a.high.y;
}

/// The two halves of a box, across its longer side.
std::array<Box, 2> Halves(const Box& box) {
  std::array<Box, 2> halves{box, box};
  const Vec2 middle = Middle(box);
  if (box.high.x - box.low.x > box.high.y - box.low.y) {
    halves[0].high.x = halves[1].low.x = middle.x;
  } else {
    halves[0].high.y = halves[1].low.y = middle.y;
  }
  return halves;
}

/// What may be hidden: a wall, or all that is in a box.
struct Target {
  explicit Target(const Box& box) : corners(CornersOf(box)), count(4), bounds(box) {}
  explicit Target(const Segment& wall)
      : corners{wall.a, wall.b, {}, {}}, count(2), bounds(BoxOf(wall)) {}

  std::array<Target, 2> Halves() const {
    if (count == 4) {
      const auto [low, high] = flatland::Halves(bounds);
      return {Target(low), Target(high)};
    }
    const Vec2 middle = 0.5 * (corners[0] + corners[1]);
    return {Target(Segment{corners[0], middle}), Target(Segment{middle, corners[1]})};
  }

  std::array<Vec2, 4> corners;
  int count;
  Box bounds;
};

/// Whether a wall crosses all lines from a box to a target. They all cross its line between the
/// points where those from corner to corner do. A wall may touch one that it hides, as at the edges
/// of a pillar, but neither lie in its line nor touch a box, which may be that of the wall itself.
bool Blocks(const Segment& wall, const Box& from, const Target& target) {
  const Vec2 along = wall.b - wall.a;
  const std::array<Vec2, 4> corners = CornersOf(from);
  double heights[4];  // above the line of the wall, times its length
  for (int i = 0; i < 4; ++i) heights[i] = Cross(along, corners[i] - wall.a);
  const double side = heights[0] > 0.0 ? 1.0 : -1.0;
  const double square_length = Dot(along, along);
  const double tolerance = kEndTolerance * square_length;
  for (double& height : heights) {
    height *= side;
    if (height <= tolerance) return false;
  }
  bool is_behind = false;
  for (int k = 0; k < target.count; ++k) {
    const double depth = -side * Cross(along, target.corners[k] - wall.a);
    if (depth < 0.0 || (target.count == 4 && depth <= tolerance)) return false;
    is_behind = is_behind || depth > tolerance;
    for (int i = 0; i < 4; ++i) {
      // Where the line from corner i to corner k crosses, from 0 to 1 along the wall.
      const Vec2 way = heights[i] * (target.corners[k] - wall.a) + depth * (corners[i] - wall.a);
      const double place = Dot(along, way);
      const double whole = (heights[i] + depth) * square_length;
      if (place < -kEndTolerance * whole || place > (1.0 + kEndTolerance) * whole) return false;
    }
  }
  return is_behind;
}

/// Whether a line from a to b meets a box.
bool Meets(const Box& box, Vec2 a, Vec2 b) {
  if (std::max(a.x, b.x) < box.low.x || std::min(a.x, b.x) > box.high.x) return false;
  if (std::max(a.y, b.y) < box.low.y || std::min(a.y, b.y) > box.high.y) return false;
  const Vec2 way = b - a;
  const Vec2 half = 0.5 * (box.high - box.low);
  const double reach = std::abs(way.x) * half.y + std::abs(way.y) * half.x;
  return std::abs(Cross(way, Middle(box) - a)) <= reach * (1.0 + 1e-9) + 1e-12;
}

/// Finds the walls that can be seen from a box.
class Finder {
 public:
  Finder(const SegmentTree& walls, const Box& from) : walls_(walls), from_(from) {}

  std::vector<uint32_t> Find() {
    Visit(walls_.root());
    return std::move(seen_);
  }

 private:
  static constexpr int kRecent = 8;

  void Visit(const SegmentTree::Child& child) {
    lines_ = kMaxLinesToBox;
    if (IsHidden(from_, Target(child.box), kMaxDepth)) return;
    if (!child.is_leaf()) {
      for (const SegmentTree::Child& each : walls_.node(child).children) Visit(each);
      return;
    }
    ForEachWall(child, [this](uint32_t index, const Segment& wall) {
      lines_ = kMaxLines;
      if (!IsHidden(from_, Target(wall), kMaxDepth)) seen_.push_back(index);
      return true;
    });
  }

  /// Calls `visit(index, wall)` for the walls of a leaf while it returns true; returns whether it
  /// did.
  template <class Visitor>
  bool ForEachWall(const SegmentTree::Child& child, Visitor visit) const {
    return walls_.ForEachWall(static_cast<size_t>(~child.index), [&](uint32_t index) {
      return visit(index, walls_.segments()[index]);
    });
  }

  bool IsHidden(const Box& from, const Target& target, int depth) {
    if (!AreApart(from, target.bounds)) return false;
    for (int i = 0; i < recent_count_; ++i) {
      if (!Blocks(recent_[i], from, target)) continue;
      std::rotate(recent_.begin(), recent_.begin() + i, recent_.begin() + i + 1);
      return true;
    }
    if (lines_-- <= 0) return false;
    is_blocked_ = false;
    if (FindBlocking(walls_.root(), Middle(from), Middle(target), from, target)) return true;
    if (!is_blocked_ || depth == 0) return false;
    const Vec2 size = from.high - from.low;
    const Vec2 target_size = target.bounds.high - target.bounds.low;
    if (std::max(size.x, size.y) > std::max(target_size.x, target_size.y)) {
      const auto [low, high] = Halves(from);
      return IsHidden(low, target, depth - 1) && IsHidden(high, target, depth - 1);
    }
    const auto [first, second] = target.Halves();
    return IsHidden(from, first, depth - 1) && IsHidden(from, second, depth - 1);
  }

  static Vec2 Middle(const Box& box) { return flatland::Middle(box); }
  static Vec2 Middle(const Target& target) {
    return target.count == 4 ? flatland::Middle(target.bounds)
                             : 0.5 * (target.corners[0] + target.corners[1]);
  }

  /// Looks among the walls that cross the line from a to b for one that blocks all lines, and
  /// remembers it. Sets is_blocked_ if any wall crosses the line before its end.
  bool FindBlocking(const SegmentTree::Child& child, Vec2 a, Vec2 b, const Box& from,
                    const Target& target) {
    if (!Meets(child.box, a, b)) return false;
    if (!child.is_leaf()) {
      const auto& children = walls_.node(child).children;
      return FindBlocking(children[0], a, b, from, target) ||
             FindBlocking(children[1], a, b, from, target);
    }
    return !ForEachWall(child, [&](uint32_t, const Segment& wall) {
      const Vec2 way = b - a;
      const double right = Cross(way, wall.a - a), left = Cross(way, wall.b - a);
      if ((right > 0.0 && left > 0.0) || (right < 0.0 && left < 0.0)) return true;
      const Vec2 along = wall.b - wall.a;
      const double before = Cross(along, a - wall.a), behind = Cross(along, b - wall.a);
      const bool crosses = before > 0.0 ? behind < -1e-9 * before : behind > -1e-9 * before;
      if (!crosses || before == 0.0) return true;
      is_blocked_ = true;
      if (!Blocks(wall, from, target)) return true;
      recent_count_ = std::min(recent_count_ + 1, kRecent);
      std::rotate(recent_.begin(), recent_.begin() + recent_count_ - 1,
                  recent_.begin() + recent_count_);
      recent_[0] = wall;
      return false;
    });
  }

  const SegmentTree& walls_;
  const Box from_;
  std::vector<uint32_t> seen_;
  std::array<Segment, kRecent> recent_;  // walls that have hidden others, the last one first
  int recent_count_ = 0;
  int lines_ = 0;  // that may still be followed for the present wall or box
  bool is_blocked_ = false;
};

}  // namespace

std::vector<uint32_t> WallsSeenFrom(const SegmentTree& walls, const Box& box) {
  if (walls.segment_count() == 0) return {};
  return Finder(walls, box).Find();
}

VisibleWalls::VisibleWalls(std::shared_ptr<const SegmentTree> walls) : walls_(std::move(walls)) {
  if (walls_->segment_count() < kMinWalls) return;
  const Box& bounds = walls_->root().box;
  const Vec2 size = bounds.high - bounds.low;
  cell_size_ = std::max(kCellSize, std::sqrt(size.x * size.y / kMaxCells));
  cell_size_ = std::max(cell_size_, std::max(size.x, size.y) / kMaxCells);
  origin_ = bounds.low;
  columns_ = static_cast<int>(size.x / cell_size_) + 1;
  rows_ = static_cast<int>(size.y / cell_size_) + 1;
  cells_ = std::make_unique<Cell[]>(static_cast<size_t>(columns_) * rows_);
}

std::shared_ptr<const VisibleWalls> VisibleWalls::Share(std::vector<Segment> segments,
                                                        const SegmentTree::Progress& progress) {
  static std::mutex mutex;
  static std::unordered_map<const SegmentTree*, std::weak_ptr<const VisibleWalls>> known;
  std::shared_ptr<const SegmentTree> tree = SegmentTree::Share(std::move(segments), progress);
  const std::lock_guard lock(mutex);
  std::weak_ptr<const VisibleWalls>& found = known[tree.get()];
  if (std::shared_ptr<const VisibleWalls> walls = found.lock()) return walls;
  auto walls = std::make_shared<const VisibleWalls>(tree);
  found = walls;
  for (auto i = known.begin(); i != known.end();) {
    i = i->second.expired() ? known.erase(i) : std::next(i);
  }
  return walls;
}

int VisibleWalls::CellAt(Vec2 point) const {
  const double column = std::floor((point.x - origin_.x) / cell_size_);
  const double row = std::floor((point.y - origin_.y) / cell_size_);
  if (!(column >= 0.0 && column < columns_ && row >= 0.0 && row < rows_)) return -1;
  return static_cast<int>(row) * columns_ + static_cast<int>(column);
}

const WallList* VisibleWalls::SeenFrom(Vec2 point) const {
  const int index = cells_ == nullptr ? -1 : CellAt(point);
  if (index < 0) return nullptr;
  Cell& cell = cells_[index];
  const WallList* const seen = cell.seen.load(std::memory_order_acquire);
  if (seen != nullptr) return seen;
  if (cell.scans.load(std::memory_order_relaxed) >= kScansBefore) return nullptr;
  const int scans = cell.scans.fetch_add(1, std::memory_order_relaxed) + 1;
  return scans == kScansBefore ? Find(index) : nullptr;
}

/// Called by one thread for each cell.
const WallList* VisibleWalls::Find(int index) const {
  const Vec2 low = origin_ + cell_size_ * Vec2{double(index % columns_), double(index / columns_)};
  const Vec2 margin{kMargin, kMargin}, size{cell_size_, cell_size_};
  Box box;
  box.Add(Segment{low - margin, low + size + margin});
  const std::vector<uint32_t> indices = WallsSeenFrom(*walls_, box);
  const std::lock_guard lock(mutex_);
  const bool pays = indices.size() <= walls_->segment_count() / 2 &&
                    found_walls_ + indices.size() <= kMaxFoundWalls;
  if (!pays) return nullptr;
  found_walls_ += indices.size();
  found_.push_back(std::make_unique<const WallList>(walls_->segments(), indices, Middle(box)));
  cells_[index].seen.store(found_.back().get(), std::memory_order_release);
  return found_.back().get();
}

}  // namespace flatland
