#include "flatland_server/visible_walls.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <unordered_map>

#include "occluders.hpp"

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
/// How often cells and walls are halved, and lines are followed, before a wall counts as seen.
constexpr int kMaxHalvings = 10;
constexpr int kMaxLines = 48;

Vec2 Middle(const Box& box) { return 0.5 * (box.low + box.high); }
Box BoxOf(const Segment& segment) {
  Box box;
  box.Add(segment);
  return box;
}
std::array<Vec2, 4> CornersOf(const Box& box) {
  return {box.low, {box.high.x, box.low.y}, box.high, {box.low.x, box.high.y}};
}
bool AreApart(const Box& a, const Box& b) { return !a.Meets(b); }

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

Vec2 Middle(const Target& target) {
  return target.count == 4 ? Middle(target.bounds) : 0.5 * (target.corners[0] + target.corners[1]);
}

/// Whether what begins and ends in these boxes crosses the chain of a chord that it crosses. True
/// for walls.
bool Counts(const Occluder& occluder, const Box& from, const Target& target) {
  return occluder.chain == nullptr ||
         (AreApart(*occluder.chain, from) && AreApart(*occluder.chain, target.bounds));
}

/// Whether an occluder crosses all lines from a box to a target. They all cross its line between
/// the points where those from corner to corner do. A wall may touch one that it hides, as at the
/// edges of a pillar, but neither lie in its line nor touch a box, which may be that of the wall
/// itself. Lines may pass a wall just past its ends, but a chord only before them.
bool Blocks(const Occluder& occluder, const Box& from, const Target& target) {
  if (!Counts(occluder, from, target)) return false;
  const Segment& wall = occluder.line;
  const double past_ends = occluder.chain == nullptr ? kEndTolerance : -kEndTolerance;
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
      if (place < -past_ends * whole || place > (1.0 + past_ends) * whole) return false;
    }
  }
  return is_behind;
}

/// Where an interval lies, as seen from another one.
bool AreApart(double low, double high, double from, double to) { return high < from || low > to; }

/// A line from a to b.
class Line {
 public:
  Line(Vec2 a, Vec2 b) : a_(a), b_(b), way_(b - a) {}

  bool Meets(const Box& box) const {
    if (AreApart(std::min(a_.x, b_.x), std::max(a_.x, b_.x), box.low.x, box.high.x)) return false;
    if (AreApart(std::min(a_.y, b_.y), std::max(a_.y, b_.y), box.low.y, box.high.y)) return false;
    const Vec2 half = 0.5 * (box.high - box.low);
    const double reach = std::abs(way_.x) * half.y + std::abs(way_.y) * half.x;
    return std::abs(Cross(way_, Middle(box) - a_)) <= reach * (1.0 + 1e-9) + 1e-12;
  }
  /// Whether it crosses a segment before its end.
  bool Crosses(const Segment& segment) const {
    const double right = Cross(way_, segment.a - a_), left = Cross(way_, segment.b - a_);
    if ((right > 0.0 && left > 0.0) || (right < 0.0 && left < 0.0)) return false;
    const Vec2 along = segment.b - segment.a;
    const double before = Cross(along, a_ - segment.a), behind = Cross(along, b_ - segment.a);
    if (before == 0.0) return false;
    return before > 0.0 ? behind < -1e-9 * before : behind > -1e-9 * before;
  }

 private:
  Vec2 a_, b_, way_;
};

/// All lines from a box to a target, and perhaps more: those between their outermost corners.
class Shaft {
 public:
  Shaft(const Box& from, const Target& target) : bounds_(from) {
    bounds_.Add(target.bounds);
    const Vec2 way = Middle(target) - Middle(from);
    left_ = {-way.y, way.x};
    const auto widen = [this](Vec2 corner) {
      low_ = std::min(low_, Dot(left_, corner));
      high_ = std::max(high_, Dot(left_, corner));
    };
    for (const Vec2& corner : CornersOf(from)) widen(corner);
    for (const Vec2& corner : CornersOf(target.bounds)) widen(corner);
  }

  bool Meets(const Box& box) const {
    if (flatland::AreApart(box, bounds_)) return false;
    const double middle = Dot(left_, Middle(box));
    const Vec2 half = 0.5 * (box.high - box.low);
    const double reach = std::abs(left_.x) * half.x + std::abs(left_.y) * half.y;
    return !AreApart(middle - reach, middle + reach, low_, high_);
  }
  bool Meets(const Segment& line) const {
    const double a = Dot(left_, line.a), b = Dot(left_, line.b);
    return !AreApart(std::min(a, b), std::max(a, b), low_, high_) &&
           !AreApart(BoxOf(line), bounds_);
  }

 private:
  Box bounds_;
  Vec2 left_;
  double low_ = 1e300, high_ = -1e300;  // of the corners, along `left_`
};

/// Finds the walls that can be seen from a box.
class Finder {
 public:
  Finder(const SegmentTree& walls, const Occluders& occluders, const Box& from)
      : walls_(walls), occluders_(occluders), from_(from) {}

  std::vector<uint32_t> Find() {
    Visit(walls_.root());
    return std::move(seen_);
  }

 private:
  static constexpr int kRecent = 8;

  void Visit(const SegmentTree::Child& child) {
    const Target target(child.box);
    if (AreApart(from_, child.box) && IsBoxHidden(target)) return;
    if (!child.is_leaf()) {
      for (const SegmentTree::Child& each : walls_.node(child).children) Visit(each);
      return;
    }
    walls_.ForEachWall(static_cast<size_t>(~child.index), [this](uint32_t index) {
      if (!IsWallHidden(Target(walls_.segments()[index]))) seen_.push_back(index);
      return true;
    });
  }

  /// Whether a single occluder hides it all; looks for it along one line.
  bool IsBoxHidden(const Target& target) {
    if (BlocksRecent(from_, target)) return true;
    const Line line(Middle(from_), Middle(target));
    return !occluders_.ForEachMeeting(line, [&](const Occluder& each) {
      const bool is_hidden = line.Crosses(each.line) && Blocks(each, from_, target);
      if (is_hidden) Remember(each);
      return !is_hidden;
    });
  }

  bool IsWallHidden(const Target& target) {
    has_candidates_ = false;
    lines_ = kMaxLines;
    return IsHidden(from_, target, target, kMaxHalvings);
  }

  /// `whole` is the wall that the target is a part of.
  bool IsHidden(const Box& from, const Target& target, const Target& whole, int halvings) {
    if (!AreApart(from, target.bounds)) return false;
    if (BlocksRecent(from, target)) return true;
    if (lines_-- <= 0) return false;
    if (!has_candidates_) FindCandidates(whole);
    const Line line(Middle(from), Middle(target));
    bool is_blocked = false;
    for (const Occluder& each : candidates_) {
      if (!line.Crosses(each.line) || !Counts(each, from, target)) continue;
      is_blocked = true;
      if (!Blocks(each, from, target)) continue;
      Remember(each);
      return true;
    }
    if (!is_blocked || halvings == 0) return false;
    const Vec2 size = from.high - from.low;
    const Vec2 target_size = target.bounds.high - target.bounds.low;
    if (std::max(size.x, size.y) > std::max(target_size.x, target_size.y)) {
      const auto [low, high] = Halves(from);
      return IsHidden(low, target, whole, halvings - 1) &&
             IsHidden(high, target, whole, halvings - 1);
    }
    const auto [first, second] = target.Halves();
    return IsHidden(from, first, whole, halvings - 1) &&
           IsHidden(from, second, whole, halvings - 1);
  }

  /// Collects what may hide a part of a wall.
  void FindCandidates(const Target& wall) {
    candidates_.clear();
    const Shaft shaft(from_, wall);
    occluders_.ForEachMeeting(shaft, [&](const Occluder& each) {
      if (shaft.Meets(each.line)) candidates_.push_back(each);
      return true;
    });
    has_candidates_ = true;
  }

  /// Whether one of those that have hidden others before blocks all lines.
  bool BlocksRecent(const Box& from, const Target& target) {
    for (int i = 0; i < recent_count_; ++i) {
      if (!Blocks(recent_[i], from, target)) continue;
      std::rotate(recent_.begin(), recent_.begin() + i, recent_.begin() + i + 1);
      return true;
    }
    return false;
  }

  void Remember(const Occluder& occluder) {
    recent_count_ = std::min(recent_count_ + 1, kRecent);
    std::rotate(recent_.begin(), recent_.begin() + recent_count_ - 1,
                recent_.begin() + recent_count_);
    recent_[0] = occluder;
  }

  const SegmentTree& walls_;
  const Occluders& occluders_;
  const Box from_;
  std::vector<uint32_t> seen_;
  std::array<Occluder, kRecent> recent_;  // those that have hidden others, the last one first
  int recent_count_ = 0;
  std::vector<Occluder> candidates_;  // for the present wall
  bool has_candidates_ = false;
  int lines_ = 0;  // that may still be followed for the present wall
};

}  // namespace

std::vector<uint32_t> WallsSeenFrom(const SegmentTree& walls, const Box& box) {
  return WallsSeenFrom(walls, Occluders(walls), box);
}

std::vector<uint32_t> WallsSeenFrom(const SegmentTree& walls, const Occluders& occluders,
                                    const Box& box) {
  if (walls.segment_count() == 0) return {};
  return Finder(walls, occluders, box).Find();
}

VisibleWalls::VisibleWalls(std::shared_ptr<const SegmentTree> walls) : walls_(std::move(walls)) {
  if (walls_->segment_count() < kMinWalls) return;
  const Box& bounds = walls_->root().box;
  const Vec2 size = bounds.high - bounds.low;
  const double cell_size = std::max(
      {kCellSize, std::sqrt(size.x * size.y / kMaxCells), std::max(size.x, size.y) / kMaxCells});
  grids_.emplace_back(bounds, cell_size, kScansBeforeHalf);
  grids_.emplace_back(bounds, 2.0 * cell_size, kScansBefore);
}

VisibleWalls::Grid::Grid(const Box& bounds, double size, int scans)
    : origin(bounds.low),
      cell_size(size),
      scans_before(scans),
      columns(static_cast<int>((bounds.high.x - bounds.low.x) / size) + 1),
      rows(static_cast<int>((bounds.high.y - bounds.low.y) / size) + 1),
      cells(std::make_unique<Cell[]>(static_cast<size_t>(columns) * rows)) {}

VisibleWalls::~VisibleWalls() = default;

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

int VisibleWalls::Grid::CellAt(Vec2 point) const {
  const double column = std::floor((point.x - origin.x) / cell_size);
  const double row = std::floor((point.y - origin.y) / cell_size);
  if (!(column >= 0.0 && column < columns && row >= 0.0 && row < rows)) return -1;
  return static_cast<int>(row) * columns + static_cast<int>(column);
}

Box VisibleWalls::Grid::BoxOf(int cell) const {
  const Vec2 low = origin + cell_size * Vec2{double(cell % columns), double(cell / columns)};
  const Vec2 margin{kMargin, kMargin}, size{cell_size, cell_size};
  Box box;
  box.Add(Segment{low - margin, low + size + margin});
  return box;
}

const WallList* VisibleWalls::SeenFrom(Vec2 point) const {
  for (const Grid& grid : grids_) {
    if (const WallList* seen = SeenFrom(grid, point)) return seen;
  }
  return nullptr;
}

const WallList* VisibleWalls::SeenFrom(const Grid& grid, Vec2 point) const {
  const int index = grid.CellAt(point);
  if (index < 0) return nullptr;
  Cell& cell = grid.cells[index];
  const WallList* const seen = cell.seen.load(std::memory_order_acquire);
  if (seen != nullptr) return seen;
  if (cell.scans.load(std::memory_order_relaxed) >= grid.scans_before) return nullptr;
  const int scans = cell.scans.fetch_add(1, std::memory_order_relaxed) + 1;
  return scans == grid.scans_before ? Find(grid, index) : nullptr;
}

/// Called by one thread for each cell.
const WallList* VisibleWalls::Find(const Grid& grid, int index) const {
  const Box box = grid.BoxOf(index);
  std::call_once(needs_occluders_, [this] { occluders_ = std::make_unique<Occluders>(*walls_); });
  const std::vector<uint32_t> indices = WallsSeenFrom(*walls_, *occluders_, box);
  const std::lock_guard lock(mutex_);
  const bool pays = indices.size() <= walls_->segment_count() / 2 &&
                    found_walls_ + indices.size() <= kMaxFoundWalls;
  if (!pays) return nullptr;
  found_walls_ += indices.size();
  found_.push_back(std::make_unique<const WallList>(walls_->segments(), indices, Middle(box)));
  grid.cells[index].seen.store(found_.back().get(), std::memory_order_release);
  return found_.back().get();
}

}  // namespace flatland
