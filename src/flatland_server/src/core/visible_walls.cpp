#include "flatland_server/visible_walls.hpp"

#include <algorithm>
#include <climits>
#include <cmath>
#include <unordered_map>

#include "occluders.hpp"
#include "wall_search.hpp"

namespace flatland {
namespace {

constexpr double kCellSize = 0.5;  // [m]
constexpr double kMaxCells = 262144;
/// With fewer walls, drawing them all is as fast.
constexpr size_t kMinWalls = 64;
/// Of all cells together: 10 to 16 bytes each.
constexpr size_t kMaxFoundWalls = 4'000'000;
/// Stands for the number of scans of a cell from which too many walls can be seen.
constexpr int kGivenUp = INT_MAX;
/// Cells are made wider by this, for rounding errors [m].
constexpr double kMargin = 1e-6;

}  // namespace

std::vector<uint32_t> WallsSeenFrom(const SegmentTree& walls, const Box& box) {
  return WallsSeenFrom(walls, Occluders(walls), box);
}

std::vector<uint32_t> WallsSeenFrom(const SegmentTree& walls, const Occluders& occluders,
                                    const Box& box) {
  WallSearch search(walls, occluders, box);
  search.Continue(INT_MAX);
  return search.seen();
}

VisibleWalls::VisibleWalls(std::shared_ptr<const SegmentTree> walls) : walls_(std::move(walls)) {
  if (walls_->segment_count() < kMinWalls) return;
  const Box& bounds = walls_->root().box;
  const Vec2 size = bounds.high - bounds.low;
  const double cell_size = std::max(
      {kCellSize, std::sqrt(size.x * size.y / kMaxCells), std::max(size.x, size.y) / kMaxCells});
  grids_.emplace_back(bounds, cell_size, kScansBeforeHalf, kScansBeforeHalf);
  grids_.emplace_back(bounds, 2.0 * cell_size, kScansBefore, kScansBeforeInBatch);
}

VisibleWalls::Grid::Grid(const Box& bounds, double size, int scans, int scans_in_batch)
    : origin(bounds.low),
      cell_size(size),
      scans_before(scans),
      scans_before_in_batch(scans_in_batch),
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

const WallList* VisibleWalls::SeenFrom(Vec2 point, int effort) const {
  for (const Grid& grid : grids_) {
    if (const WallList* seen = SeenFrom(grid, point, effort)) return seen;
  }
  return nullptr;
}

const WallList* VisibleWalls::SeenFrom(const Grid& grid, Vec2 point, int effort) const {
  const int index = grid.CellAt(point);
  if (index < 0) return nullptr;
  Cell& cell = grid.cells[index];
  const auto seen = [&cell] {
    const Found* const found = cell.seen.load(std::memory_order_acquire);
    return found == nullptr ? nullptr : &found->list;
  };
  if (const WallList* const list = seen()) return list;
  int scans = cell.scans.load(std::memory_order_relaxed);
  if (scans == kGivenUp) return nullptr;
  const bool is_batch = effort == kWholeSearch;
  if (const int before = is_batch ? grid.scans_before_in_batch : grid.scans_before;
      scans < before) {
    const bool is_counted =
        cell.scans.compare_exchange_strong(scans, scans + 1, std::memory_order_relaxed);
    if (!is_counted || scans + 1 < before) return nullptr;
    const std::lock_guard lock(mutex_);
    waiting_.push_back({&grid, index, nullptr});
  }
  SearchOn(effort);
  return seen();
}

void VisibleWalls::Prepare() const {
  const std::lock_guard lock(mutex_);
  if (!grids_.empty()) PrepareLocked();
}

void VisibleWalls::PrepareLocked() const {
  if (occluders_ == nullptr) occluders_ = std::make_unique<const Occluders>(*walls_);
}

/// Of those that wait, the first ones are searched for: as many as there are threads that do so.
void VisibleWalls::SearchOn(int effort) const {
  std::unique_lock lock(mutex_);
  if (waiting_.empty()) return;
  Search next = std::move(waiting_.front());
  waiting_.pop_front();
  PrepareLocked();
  lock.unlock();
  if (next.search == nullptr) next.search = Begin(*next.grid, next.cell);
  const bool has_ended = next.search->Continue(effort);
  lock.lock();
  if (!has_ended) {
    waiting_.push_front(std::move(next));
    return;
  }
  KeepLocked(*next.grid, next.cell, next.search->seen());
}

std::unique_ptr<WallSearch> VisibleWalls::Begin(const Grid& grid, int cell) const {
  const Box box = grid.BoxOf(cell);
  const Found* around = nullptr;
  if (&grid != &grids_[1]) {
    const int larger = grids_[1].CellAt(0.5 * (box.low + box.high));
    if (larger >= 0) around = grids_[1].cells[larger].seen.load(std::memory_order_acquire);
  }
  return std::make_unique<WallSearch>(*walls_, *occluders_, box,
                                      around == nullptr ? nullptr : &around->indices);
}

void VisibleWalls::KeepLocked(const Grid& grid, int index, std::vector<uint32_t> indices) const {
  Cell& cell = grid.cells[index];
  if (cell.seen != nullptr) return;
  const bool pays = indices.size() <= walls_->segment_count() / 2 &&
                    found_walls_ + indices.size() <= kMaxFoundWalls;
  if (!pays) {
    cell.scans = kGivenUp;
    return;
  }
  found_walls_ += indices.size();
  const Box box = grid.BoxOf(index);
  const WallList list(walls_->segments(), indices, 0.5 * (box.low + box.high));
  found_.push_back(std::make_unique<const Found>(Found{std::move(indices), list}));
  cell.seen.store(found_.back().get(), std::memory_order_release);
}

size_t VisibleWalls::found_count() const {
  const std::lock_guard lock(mutex_);
  return found_.size();
}

std::vector<uint32_t> VisibleWalls::GetKnown() const {
  const std::lock_guard lock(mutex_);
  std::vector<uint32_t> known;
  for (const Grid& grid : grids_) {
    for (int i = 0; i < grid.columns * grid.rows; ++i) {
      const Cell& cell = grid.cells[i];
      if (const Found* const found = cell.seen) {
        known.push_back(static_cast<uint32_t>(found->indices.size()));
        known.insert(known.end(), found->indices.begin(), found->indices.end());
      } else {
        known.push_back(cell.scans == kGivenUp ? kAllWalls : kUnknown);
      }
    }
  }
  return known;
}

bool VisibleWalls::Take(const std::vector<uint32_t>& known) const {
  const auto count = static_cast<uint32_t>(walls_->segment_count());
  // Twice the same: first only a check.
  for (const bool is_check : {true, false}) {
    const std::lock_guard lock(mutex_);
    auto next = known.begin();
    for (const Grid& grid : grids_) {
      for (int i = 0; i < grid.columns * grid.rows; ++i) {
        if (next == known.end()) return false;
        const uint32_t number = *next++;
        Cell& cell = grid.cells[i];
        if (number == kAllWalls && !is_check) cell.scans = kGivenUp;
        if (number == kAllWalls || number == kUnknown) continue;
        if (number > known.end() - next) return false;
        const auto end = next + number;
        if (is_check && std::any_of(next, end, [&](uint32_t each) { return each >= count; })) {
          return false;
        }
        if (!is_check) KeepLocked(grid, i, {next, end});
        next = end;
      }
    }
    if (next != known.end()) return false;
  }
  return true;
}

}  // namespace flatland
