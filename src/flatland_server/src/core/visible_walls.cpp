/// Finds the walls that can be seen from any point of a box.
///
/// Need: a lidar in an office sees a hundred walls of thousands. A scan that searches the tree finds
/// out anew each time that it need not draw the others.
///
/// Method: walls that share corners are followed to the left and to the right, as seen from the
/// centre c of the box: a chain. What hides a point x from the whole box is a part of a chain, from
/// P on the right to Q on the left, that is nearer to c than x, if x is to the left of the lines
/// from all corners of the box past P, and to the right of those past Q. Angles are looked at from
/// c: to be on the safe side, at those that these lines have in the infinite.
///
/// Proof: let v be a point of the box. Outside of the disc around the box, the line from v to x
/// gets ever farther from c. It passes to the left of P at the radius of P, and to the right of Q
/// at the radius of Q, between the least and the greatest radius of the chain. The chain, which
/// leads from P to Q, crosses it there, before x. All of the chain must be outside of the disc; it
/// may go to and fro.
///
/// Data: directions are divided into buckets. Each has the radius behind which all is hidden, as a
/// depth buffer (Horizon), and the tree is searched as it is for a scan (tree_search.hpp), in rings
/// from near to far: the chain of each wall that is not hidden is drawn. Last, the tree is searched
/// once more for all that the whole buffer does not hide.

#include "flatland_server/visible_walls.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <functional>
#include <limits>
#include <mutex>
#include <numeric>
#include <string_view>
#include <unordered_map>
#include <utility>

#include "flatland_server/beam_fan.hpp"
#include "tree_search.hpp"

namespace flatland {
namespace {

constexpr double kCellSize = 0.25;  // [m]
constexpr double kMaxCells = 262'144;
/// With fewer walls, drawing them all is as fast.
constexpr size_t kMinWalls = 64;
/// Of all cells together: 4 bytes each.
constexpr size_t kMaxFound = 4'000'000;
/// For rounding errors: of angles [rad], and by which a box is made larger.
constexpr double kAngleTolerance = 1e-6, kLarger = 1.0 + 1e-6;
/// As many walls of a chain are followed while they do not lead on.
constexpr size_t kMaxDetour = 3;
/// Walls lead on if they turn more than this [buckets], the rounding errors of a detour.
constexpr double kLeastTurn = 1e-6;

constexpr int kBuckets = 512;
constexpr float kFirstRing = 1.0f, kNextRing = 1.5f, kLastRing = 64.0f;

/// Of the first walls: whether all are equal is compared anyway.
size_t HashOf(const std::vector<Segment>& segments) {
  const auto* bytes = reinterpret_cast<const char*>(segments.data());
  const size_t count = std::min<size_t>(segments.size(), 100);
  return std::hash<std::string_view>()({bytes, count * sizeof(Segment)});
}

bool AreEqual(const std::vector<Segment>& a, const std::vector<Segment>& b) {
  return a.size() == b.size() &&
         (a.empty() || std::memcmp(a.data(), b.data(), a.size() * sizeof(Segment)) == 0);
}

/// The directions between the buckets of diamond angles, and the number of buckets before each.
struct Buckets {
  Buckets() {
    for (int i = 0; i < kBuckets; ++i) {
      const double diamond = 4.0 * i / kBuckets - 2.0;
      const double y = std::abs(diamond) > 1.0 ? std::copysign(2.0, diamond) - diamond : diamond;
      const double x = 1.0 - std::abs(diamond);
      directions[i] = 1.0 / std::hypot(x, y) * Vec2{x, y};
      angles[i] = std::atan2(directions[i].y, directions[i].x);
    }
    angles[0] = -M_PI;
    for (int i = 0; i < kBuckets + 2; ++i) before[i] = std::min(i, kBuckets);
  }
  /// Their number counted from -x, with fractions.
  static double Of(Vec2 v) { return (DiamondAngle(v) + 2.0) * (kBuckets / 4.0); }

  std::array<Vec2, kBuckets> directions;
  std::array<double, kBuckets> angles;  // [rad]
  std::array<int, kBuckets + 2> before;
};

class Finder {
 public:
  std::vector<uint32_t> Find(const SegmentTree& walls, const Box& box) {
    walls_ = &walls;
    center_ = 0.5 * (box.low + box.high);
    const Vec2 half = 0.5 * kLarger * (box.high - box.low);
    box_ = {-1.0 * half, {half.x, -half.y}, half, {-half.x, half.y}};
    radius_ = kLarger * std::sqrt(Dot(half, half));
    lists_.MakeRoomFor(walls);
    horizon_.Begin(kBuckets);
    inverse_.assign(kBuckets, 0.0);
    is_in_chain_.assign(walls.segment_count(), 0);
    std::vector<uint32_t> found;
    float from = 0.0f;
    for (float to = kFirstRing; from < kLastRing; from = std::exchange(to, kNextRing * to)) {
      found.clear();
      Search(from, to, found);
      for (const uint32_t wall : found) {
        if (is_in_chain_[wall] == 0) DrawChainOf(wall);
      }
    }
    found.clear();
    Search(0.0f, std::numeric_limits<float>::infinity(), found);
    return found;
  }

 private:
  /// A point of a chain, in the direction between two buckets.
  struct Sample {
    double angle;                    // [rad]
    double right_limit, left_limit;  // where what the chain hides begins to the left, and right
    double far;                      // greatest radius since the sample before [m]
  };

  static const Buckets& buckets() {
    static const Buckets buckets;
    return buckets;
  }
  /// The index and the angle [rad] of a direction between two buckets, counted from -x on.
  static int IndexOf(int boundary) { return (boundary % kBuckets + kBuckets) % kBuckets; }
  static double AngleOf(int boundary) {
    const int index = IndexOf(boundary);
    return buckets().angles[index] + 2.0 * M_PI * ((boundary - index) / kBuckets);
  }
  /// Buckets from one direction to another, to the left, less than half a rotation.
  static double Turn(Vec2 from, Vec2 to) {
    const double turn = Buckets::Of(to) - Buckets::Of(from);
    return turn > kBuckets / 2 ? turn - kBuckets : turn < -kBuckets / 2 ? turn + kBuckets : turn;
  }
  static bool IsAt(Vec2 a, Vec2 b) { return a.x == b.x && a.y == b.y; }
  static Vec2 OtherEnd(const Segment& wall, Vec2 end) {
    return IsAt(wall.a, end) ? wall.b : wall.a;
  }

  void Search(float from, float to, std::vector<uint32_t>& found);

  bool IsOutside(Vec2 a, Vec2 b) const {
    const Vec2 along = b - a;
    const Vec2 near = a + std::clamp(-Dot(a, along) / Dot(along, along), 0.0, 1.0) * along;
    return Dot(near, near) > radius_ * radius_;
  }
  /// Goes on along the wall that turns most to that side, 1 is left, of those outside of the disc.
  /// Returns whether there is one.
  bool Follow(uint32_t* wall, Vec2* corner, double side) const {
    Box here;
    here.Add(*corner);
    double most = -kBuckets;
    uint32_t next = 0;
    walls_->ForEachLeafAt(here, [&](size_t leaf) {
      walls_->ForEachWall(leaf, [&](uint32_t index) {
        const Segment& each = walls_->segments()[index];
        if (index == *wall || !(IsAt(each.a, *corner) || IsAt(each.b, *corner))) return;
        const Vec2 from = *corner - center_, to = OtherEnd(each, *corner) - center_;
        const double turn = side * Turn(from, to);
        if (!(turn > most) || !IsOutside(from, to)) return;
        most = turn;
        next = index;
      });
    });
    if (most == -kBuckets) return false;
    *wall = next;
    *corner = OtherEnd(walls_->segments()[next], *corner);
    return true;
  }
  Sample SampleAt(int boundary, double radius, double far) const {
    const Vec2 point = radius * buckets().directions[IndexOf(boundary)];
    double most = 0.0, least = 0.0;
    for (const Vec2& corner : box_) {
      const double slope = Cross(corner, point) / (radius * radius - Dot(corner, point));
      most = std::max(most, slope);
      least = std::min(least, slope);
    }
    const double angle = AngleOf(boundary);
    return {angle, angle + std::atan(most) + kAngleTolerance,
            angle + std::atan(least) - kAngleTolerance, std::max(far, radius)};
  }
  /// Follows a chain from a corner of a wall on, to the left by side 1, to the right by -1, and
  /// samples it from a boundary on. A detour that leads on in the end belongs to it.
  void Trace(uint32_t wall, Vec2 corner, double side, int boundary, std::vector<Sample>& samples) {
    Vec2 from = corner - center_;
    double place = Buckets::Of(from), farthest = place;
    double far = std::sqrt(Dot(from, from));
    corner = OtherEnd(walls_->segments()[wall], corner);
    samples.clear();
    detour_.clear();
    do {
      const Vec2 to = corner - center_;
      place += Turn(from, to);
      const double most = std::sqrt(std::max(Dot(from, from), Dot(to, to)));
      for (; side * boundary <= side * place; boundary += static_cast<int>(side)) {
        const Vec2 direction = buckets().directions[IndexOf(boundary)];
        const double radius = Cross(from, to) / Cross(direction, to - from);
        samples.push_back(SampleAt(boundary, std::clamp(radius, radius_, most), far));
        far = radius;
      }
      far = std::max(far, std::sqrt(Dot(to, to)));
      from = to;
      detour_.push_back(wall);
      if (side * (place - farthest) > kLeastTurn) {
        farthest = place;
        for (const uint32_t each : detour_) is_in_chain_[each] = 1;
        detour_.clear();
      }
    } while (detour_.size() <= kMaxDetour && std::abs(place - farthest) < kBuckets / 4 &&
             samples.size() < kBuckets && Follow(&wall, &corner, side));
  }
  void DrawChainOf(uint32_t wall) {
    is_in_chain_[wall] = 1;
    const Segment& each = walls_->segments()[wall];
    const bool is_to_the_left = Cross(each.a - center_, each.b - center_) > 0.0;
    const Vec2 right = is_to_the_left ? each.a : each.b;
    if (!IsOutside(each.a - center_, each.b - center_)) return;
    const int first = static_cast<int>(std::ceil(Buckets::Of(right - center_)));
    Trace(wall, right, 1.0, first, left_);
    right_.clear();
    Vec2 corner = right;
    if (Follow(&wall, &corner, -1.0)) Trace(wall, right, -1.0, first - 1, right_);
    Join();
    Draw(first - static_cast<int>(right_.size()));
  }
  /// Makes one chain, from right to left.
  void Join() {
    const size_t count = right_.size();
    if (count > 0 && !left_.empty()) left_[0].far = std::max(left_[0].far, right_[0].far);
    for (size_t i = 0; i + 1 < count; ++i) right_[i].far = right_[i + 1].far;
    left_.insert(left_.begin(), right_.rbegin(), right_.rend());
  }
  /// Draws the chain, with its first sample at a boundary, on all buckets that it hides.
  void Draw(int first) {
    const std::vector<Sample>& chain = left_;
    const int count = static_cast<int>(chain.size());
    for (int k = 0; k + 1 < count; ++k) {
      double farthest = chain[k + 1].far;
      int right = k, left = k + 1;
      while (right >= 0 && chain[right].right_limit > chain[k].angle) {
        farthest = std::max(farthest, chain[right--].far);
      }
      while (left < count && chain[left].left_limit < chain[k + 1].angle) {
        if (++left < count) farthest = std::max(farthest, chain[left].far);
      }
      if (right < 0 || left == count) continue;
      double& inverse = inverse_[IndexOf(first + k)];
      inverse = std::max(inverse, 1.0 / farthest);
    }
  }

  const SegmentTree* walls_ = nullptr;
  Vec2 center_;
  std::array<Vec2, 4> box_;  // its corners, relative to the centre
  double radius_ = 0.0;      // of the disc around it
  AlignedDoubles inverse_;   // of the radius behind which all is hidden, by bucket [1/m]
  Horizon horizon_;
  SearchLists lists_;
  std::vector<char> is_in_chain_;  // by wall
  std::vector<uint32_t> detour_;
  std::vector<Sample> left_, right_;  // of a chain
};

FLATLAND_CLONES void FindUnhiddenWalls(const SegmentTree& walls, const TreeView& tree,
                                       const Hiding& hiding, SearchLists& lists,
                                       std::vector<uint32_t>& found) {
  FindUnhidden(walls, tree, hiding, lists, [&](const int* visible, int count) {
    found.insert(found.end(), visible, visible + count);
  });
}

FLATLAND_CLONES void UpdateHorizon(Horizon& horizon, const double* inverse) {
  horizon.Update(inverse);
}

void Finder::Search(float from, float to, std::vector<uint32_t>& found) {
  UpdateHorizon(horizon_, inverse_.data());
  const TreeView tree(*walls_, center_, Rotation(0.0), kBuckets / 4.0, from, to);
  FindUnhiddenWalls(*walls_, tree, {horizon_, buckets().before.data(), kBuckets}, lists_, found);
}

}  // namespace

std::vector<uint32_t> WallsSeenFrom(const SegmentTree& walls, const Box& box) {
  thread_local Finder finder;  // keeps its memory
  return walls.segment_count() == 0 ? std::vector<uint32_t>() : finder.Find(walls, box);
}

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
  // Drops unused known; this takes no time compared with building a new one.
  for (auto i = known.begin(); i != known.end();) {
    i = i->second.expired() ? known.erase(i) : std::next(i);
  }
  known.emplace(hash, walls);
  return walls;
}

VisibleWalls::VisibleWalls(std::vector<Segment> segments, const SegmentTree::Progress& progress)
    : all_(std::move(segments), progress) {
  if (all_.segment_count() < kMinWalls) return;
  Box bounds;
  for (const Segment& wall : all_.segments()) bounds.Add(wall);
  const Vec2 size = bounds.high - bounds.low;
  cell_size_ = std::max({kCellSize, std::sqrt(size.x * size.y / kMaxCells),
                         std::max(size.x, size.y) / kMaxCells});
  origin_ = bounds.low;
  columns_ = static_cast<int>(size.x / cell_size_) + 1;
  rows_ = static_cast<int>(size.y / cell_size_) + 1;
  cells_ = std::make_unique<Cell[]>(static_cast<size_t>(columns_) * rows_);
}

VisibleWalls::~VisibleWalls() {
  for (int i = 0; i < columns_ * rows_; ++i) delete cells_[i].walls.load();
}

const std::vector<uint32_t>* VisibleWalls::From(Vec2 point) const {
  if (cells_ == nullptr) return nullptr;
  const double column = std::floor((point.x - origin_.x) / cell_size_);
  const double row = std::floor((point.y - origin_.y) / cell_size_);
  if (!(column >= 0.0 && column < columns_ && row >= 0.0 && row < rows_)) return nullptr;
  Cell& cell = cells_[static_cast<int>(row) * columns_ + static_cast<int>(column)];
  const std::vector<uint32_t>* const walls = cell.walls.load(std::memory_order_acquire);
  if (walls != nullptr || cell.scans.load(std::memory_order_relaxed) >= kScansBefore) return walls;
  if (cell.scans.fetch_add(1, std::memory_order_relaxed) + 1 != kScansBefore) return nullptr;
  return Find(cell, {origin_ + cell_size_ * Vec2{column, row},
                     origin_ + cell_size_ * Vec2{column + 1.0, row + 1.0}});
}

/// Called by one thread for each cell.
const std::vector<uint32_t>* VisibleWalls::Find(Cell& cell, const Box& box) const {
  std::vector<uint32_t> walls = WallsSeenFrom(all_, box);
  walls.shrink_to_fit();
  const bool pays = walls.size() <= all_.segment_count() / 2;
  if (!pays || found_.fetch_add(walls.size()) + walls.size() > kMaxFound) return nullptr;
  const auto* const found = new std::vector<uint32_t>(std::move(walls));
  cell.walls.store(found, std::memory_order_release);
  return found;
}

}  // namespace flatland
