#include "flatland_server/segment_tree.hpp"

#include <algorithm>
#include <cstring>
#include <functional>
#include <limits>
#include <mutex>
#include <numeric>
#include <string_view>
#include <unordered_map>

namespace flatland {
namespace {

using Iterator = std::vector<uint32_t>::iterator;

constexpr int kBins = 16;
/// From this depth on each node is split in half, whatever the boxes: this limits the depth.
constexpr int kMaxHeuristicDepth = 64;

Vec2 TwiceCenter(const Segment& segment) { return segment.a + segment.b; }
double Along(Vec2 v, int axis) { return axis == 0 ? v.x : v.y; }

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

/// The cost of a child: its probability to be visited, which grows with its box, times the number
/// of leaves that its walls fill.
double CostOf(const Box& box, int walls) {
  constexpr int kLeafSize = SegmentTree::kLeafSize;
  return walls == 0 ? 0.0 : box.half_perimeter() * ((walls + kLeafSize - 1) / kLeafSize);
}

/// Sorts walls by their centres along an axis into bins of equal width. A cut lies between two
/// bins.
class Binning {
 public:
  /// `centers` is the box of all the walls' doubled centres.
  Binning(const Box& centers, int axis)
      : axis_(axis), from_(Along(centers.low, axis)), size_(Along(centers.high, axis) - from_) {}

  int axis() const { return axis_; }
  /// False if all centres are equal along the axis.
  bool is_possible() const { return size_ > 0.0; }
  int BinOf(const Segment& segment) const {
    const double part = (Along(TwiceCenter(segment), axis_) - from_) / size_;
    return std::min(kBins - 1, static_cast<int>(part * kBins));
  }

 private:
  int axis_;
  double from_;
  double size_;
};

/// A division of walls: those in the bins below `bin` along an axis, and the others.
struct Cut {
  int axis = 0;
  int bin = 0;  // 0: no division
  double cost = std::numeric_limits<double>::infinity();
};

/// The cheapest cut between two bins, with walls on both sides; an infinite cost if there is none.
Cut FindCut(const Binning& binning, const std::vector<Segment>& segments, Iterator begin,
            Iterator end) {
  Box boxes[kBins];
  int counts[kBins] = {};
  for (Iterator i = begin; i != end; ++i) {
    const int bin = binning.BinOf(segments[*i]);
    boxes[bin].Add(segments[*i]);
    ++counts[bin];
  }
  double costs_above[kBins] = {};
  Box box;
  int count = 0;
  for (int bin = kBins - 1; bin > 0; --bin) {
    box.Add(boxes[bin]);
    count += counts[bin];
    costs_above[bin] = CostOf(box, count);
  }
  box = Box();
  count = 0;
  Cut best;
  for (int bin = 1; bin < kBins; ++bin) {
    box.Add(boxes[bin - 1]);
    count += counts[bin - 1];
    const double cost = CostOf(box, count) + costs_above[bin];
    if (count == 0 || count == end - begin || cost >= best.cost) continue;
    best = {binning.axis(), bin, cost};
  }
  return best;
}

}  // namespace

std::shared_ptr<const SegmentTree> SegmentTree::Share(std::vector<Segment> segments,
                                                      const Progress& progress) {
  static std::mutex mutex;
  static std::unordered_multimap<size_t, std::weak_ptr<const SegmentTree>> trees;
  const size_t hash = HashOf(segments);
  const auto find = [&](const std::vector<Segment>& wanted) {
    for (auto [i, end] = trees.equal_range(hash); i != end; ++i) {
      const std::shared_ptr<const SegmentTree> tree = i->second.lock();
      if (tree && AreEqual(tree->segments_, wanted)) return tree;
    }
    return std::shared_ptr<const SegmentTree>();
  };
  {
    const std::lock_guard lock(mutex);
    if (auto tree = find(segments)) return tree;
  }
  // Not locked: `progress` may wait for another thread, which may be in here too.
  auto tree = std::make_shared<const SegmentTree>(std::move(segments), progress);
  const std::lock_guard lock(mutex);
  if (auto other = find(tree->segments_)) return other;
  // Drops unused trees; this takes no time compared with building a new one.
  for (auto i = trees.begin(); i != trees.end();) {
    i = i->second.expired() ? trees.erase(i) : std::next(i);
  }
  trees.emplace(hash, tree);
  return tree;
}

SegmentTree::SegmentTree(std::vector<Segment> segments, const Progress& progress, size_t max_copied)
    : segments_(std::move(segments)) {
  if (segments_.empty()) return;
  std::vector<uint32_t> indices(segments_.size());
  std::iota(indices.begin(), indices.end(), 0);
  Filling filling{progress, segments_.size() <= max_copied};
  root_ = Build(indices.begin(), indices.end(), 0, filling);
}

SegmentTree::Child SegmentTree::Build(Iterator begin, Iterator end, int depth, Filling& filling) {
  Child child;
  for (Iterator i = begin; i != end; ++i) child.box.Add(segments_[*i]);
  if (end - begin <= kLeafSize) {
    child.index = AddLeaf(begin, end, filling);
    return child;
  }
  child.index = static_cast<int32_t>(nodes_.size());
  nodes_.emplace_back();
  const Iterator middle = Split(begin, end, depth);
  const Child low = Build(begin, middle, depth + 1, filling);
  const Child high = Build(middle, end, depth + 1, filling);
  nodes_[child.index] = {{low, high}};
  return child;
}

int32_t SegmentTree::AddLeaf(Iterator begin, Iterator end, Filling& filling) {
  const auto count = static_cast<size_t>(end - begin);
  Indices& indices = indices_.emplace_back();
  std::fill(std::copy(begin, end, indices.begin()), indices.end(), *(end - 1));
  if (filling.has_copies) AddCopies(begin, end);
  const size_t before = filling.done;
  filling.done += count;
  const bool is_due = before / kProgressStep != filling.done / kProgressStep;
  if (filling.progress && (is_due || filling.done == segments_.size())) {
    filling.progress(filling.done);
  }
  return ~static_cast<int32_t>(indices_.size() - 1);
}

void SegmentTree::AddCopies(Iterator begin, Iterator end) {
  Leaf leaf;
  for (double* values : {leaf.ax, leaf.ay, leaf.bx, leaf.by}) {
    std::fill_n(values, kLeafSize, std::numeric_limits<double>::quiet_NaN());
  }
  for (int lane = 0; begin != end; ++begin, ++lane) {
    const Segment& segment = segments_[*begin];
    leaf.ax[lane] = segment.a.x;
    leaf.ay[lane] = segment.a.y;
    leaf.bx[lane] = segment.b.x;
    leaf.by[lane] = segment.b.y;
  }
  leaves_.push_back(leaf);
}

/// Reorders the walls such that those of the first child come before those of the second. Returns
/// where the second's begin.
SegmentTree::Iterator SegmentTree::Split(Iterator begin, Iterator end, int depth) {
  Box centers;
  for (Iterator i = begin; i != end; ++i) {
    const Vec2 center = TwiceCenter(segments_[*i]);
    centers.Add(Segment{center, center});
  }
  Cut best;
  for (int axis = 0; axis < 2 && depth < kMaxHeuristicDepth; ++axis) {
    const Binning binning(centers, axis);
    if (!binning.is_possible()) continue;
    const Cut cut = FindCut(binning, segments_, begin, end);
    if (cut.cost < best.cost) best = cut;
  }
  if (best.bin > 0) {
    const Binning binning(centers, best.axis);
    return std::partition(
        begin, end, [&](uint32_t index) { return binning.BinOf(segments_[index]) < best.bin; });
  }
  const Vec2 size = centers.high - centers.low;
  const int axis = size.y > size.x ? 1 : 0;
  const Iterator middle = begin + (end - begin) / 2;
  std::nth_element(begin, middle, end, [&](uint32_t a, uint32_t b) {
    return Along(TwiceCenter(segments_[a]), axis) < Along(TwiceCenter(segments_[b]), axis);
  });
  return middle;
}

}  // namespace flatland
