#include "sight/visible_walls.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <functional>
#include <mutex>
#include <string_view>
#include <unordered_map>
#include <utility>

#include "sight/walls_seen_from.hpp"

namespace flatland {
namespace {

constexpr double kCellSize = 0.5;  // [m]
constexpr double kMaxCells = 262'144;
/// Most indices kept for all cells together, of 4 bytes each.
constexpr size_t kMaxFound = 4'000'000;
/// A margin for rounding errors of distances.
constexpr double kLarger = 1.0 + 1e-6;

/// A hash of the first walls. If hashes are equal, all walls are compared.
size_t HashOf(const std::vector<Segment>& segments) {
  const auto* bytes = reinterpret_cast<const char*>(segments.data());
  const size_t count = std::min<size_t>(segments.size(), 100);
  return std::hash<std::string_view>()({bytes, count * sizeof(Segment)});
}

bool AreEqual(const std::vector<Segment>& a, const std::vector<Segment>& b) {
  return a.size() == b.size() &&
         (a.empty() || std::memcmp(a.data(), b.data(), a.size() * sizeof(Segment)) == 0);
}

}  // namespace

std::shared_ptr<const VisibleWalls> VisibleWalls::Share(std::vector<Segment> segments,
                                                        const SegmentTree::Progress& progress) {
  static std::mutex mutex;
  static std::unordered_multimap<size_t, std::weak_ptr<const VisibleWalls>> known;
  const size_t hash = HashOf(segments);
  const auto find = [&](const std::vector<Segment>& wanted) {
    for (auto [i, end] = known.equal_range(hash); i != end; ++i) {
      const std::shared_ptr<const VisibleWalls> walls = i->second.lock();
      if (walls && AreEqual(walls->all().segments(), wanted)) return walls;
    }
    return std::shared_ptr<const VisibleWalls>();
  };
  {
    const std::lock_guard lock(mutex);
    if (auto walls = find(segments)) return walls;
  }
  // Not locked: `progress` may wait for another thread, which may be in here too.
  auto walls = std::make_shared<const VisibleWalls>(std::move(segments), progress);
  const std::lock_guard lock(mutex);
  if (auto other = find(walls->all().segments())) return other;
  // Drops the entries that are not in use, which is fast compared with building a new one.
  for (auto i = known.begin(); i != known.end();) {
    i = i->second.expired() ? known.erase(i) : std::next(i);
  }
  known.emplace(hash, walls);
  return walls;
}

VisibleWalls::VisibleWalls(std::vector<Segment> segments, const SegmentTree::Progress& progress)
    : all_(std::move(segments), progress) {
  if (all_.segment_count() <= SegmentTree::kFew) return;
  corners_ = std::make_unique<const Corners>(all_.segments());
  Box bounds;
  for (const Segment& wall : all_.segments()) bounds.Add(wall);
  const Vec2 size = bounds.high - bounds.low;
  cell_size_ = std::max(
      {kCellSize, std::sqrt(size.x * size.y / kMaxCells), std::max(size.x, size.y) / kMaxCells});
  origin_ = bounds.low;
  columns_ = static_cast<int>(size.x / cell_size_) + 1;
  rows_ = static_cast<int>(size.y / cell_size_) + 1;
  cells_ = std::make_unique<Cell[]>(static_cast<size_t>(columns_) * rows_);
}

VisibleWalls::~VisibleWalls() {
  for (int i = 0; i < columns_ * rows_; ++i) delete[] cells_[i].walls.load();
}

WallList VisibleWalls::From(Vec2 point, double range, const void*& address) const {
  if (cells_ == nullptr) return {};
  const double column = std::floor((point.x - origin_.x) / cell_size_);
  const double row = std::floor((point.y - origin_.y) / cell_size_);
  if (!(column >= 0.0 && column < columns_ && row >= 0.0 && row < rows_)) return {};
  Cell& cell = cells_[static_cast<int>(row) * columns_ + static_cast<int>(column)];
  address = &cell;
  const uint32_t* walls = cell.walls.load(std::memory_order_acquire);
  if (walls == nullptr) {
    if (cell.scans.load(std::memory_order_relaxed) >= kScansBefore) return {};
    if (cell.scans.fetch_add(1, std::memory_order_relaxed) + 1 != kScansBefore) return {};
    Find(cell, {origin_ + cell_size_ * Vec2{column, row},
                origin_ + cell_size_ * Vec2{column + 1.0, row + 1.0}});
    walls = cell.walls.load(std::memory_order_relaxed);
    if (walls == nullptr) return {};
  }
  return {walls,
          cell.within[std::lower_bound(kRanges.begin(), kRanges.end(), range) - kRanges.begin()]};
}

/// Called by only one thread for a cell.
void VisibleWalls::Find(Cell& cell, const Box& box) const {
  const std::optional<std::vector<uint32_t>> walls = WallsSeenFrom(all_, *corners_, box);
  constexpr size_t kMost = std::numeric_limits<Cell::Counts::value_type>::max();
  // With half of the walls, the tree is as fast.
  if (!walls || walls->size() > std::min(all_.segment_count() / 2, kMost)) return;
  if (found_.fetch_add(walls->size()) + walls->size() > kMaxFound) return;
  std::vector<std::pair<double, uint32_t>> sorted;  // by a lower bound of their distance
  for (const uint32_t wall : *walls) {
    Box bounds;
    bounds.Add(all_.segments()[wall]);
    sorted.emplace_back(box.Distance(bounds), wall);
  }
  std::sort(sorted.begin(), sorted.end());
  for (size_t i = 0; i < kRanges.size(); ++i) {
    const auto is_within = [&](const auto& each) { return each.first <= kLarger * kRanges[i]; };
    const auto end = std::partition_point(sorted.begin(), sorted.end(), is_within);
    cell.within[i] = static_cast<uint16_t>(end - sorted.begin());
  }
  auto* const found = new uint32_t[sorted.size()];
  std::transform(sorted.begin(), sorted.end(), found, [](const auto& each) { return each.second; });
  cell.walls.store(found, std::memory_order_release);
}

}  // namespace flatland
