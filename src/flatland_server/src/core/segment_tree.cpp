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

constexpr int kBins = 16;
/// From this depth on walls are halved, whatever the boxes: so the depth is limited.
constexpr int kMostCleverDepth = 64;

Vec2 TwiceCenter(const Segment& segment) { return segment.a + segment.b; }
double Along(Vec2 v, int axis) { return axis == 0 ? v.x : v.y; }

size_t HashOf(const std::vector<Segment>& segments) {
  const auto* bytes = reinterpret_cast<const char*>(segments.data());
  return std::hash<std::string_view>()({bytes, segments.size() * sizeof(Segment)});
}

bool AreEqual(const std::vector<Segment>& a, const std::vector<Segment>& b) {
  return a.size() == b.size() &&
         (a.empty() || std::memcmp(a.data(), b.data(), a.size() * sizeof(Segment)) == 0);
}

}  // namespace

void Box::Add(const Segment& segment) {
  for (const Vec2& end : {segment.a, segment.b}) {
    low = {std::min(low.x, end.x), std::min(low.y, end.y)};
    high = {std::max(high.x, end.x), std::max(high.y, end.y)};
  }
}

void Box::Add(const Box& other) {
  low = {std::min(low.x, other.low.x), std::min(low.y, other.low.y)};
  high = {std::max(high.x, other.high.x), std::max(high.y, other.high.y)};
}

std::shared_ptr<const SegmentTree> SegmentTree::Share(const std::vector<Segment>& segments) {
  static std::mutex mutex;
  static std::unordered_multimap<size_t, std::weak_ptr<const SegmentTree>> trees;
  const std::lock_guard lock(mutex);
  const size_t hash = HashOf(segments);
  for (auto [i, end] = trees.equal_range(hash); i != end; ++i) {
    const std::shared_ptr<const SegmentTree> tree = i->second.lock();
    if (tree && AreEqual(tree->segments_, segments)) return tree;
  }
  // A new one takes long anyway: a good time to forget those that nobody uses any more.
  for (auto i = trees.begin(); i != trees.end();) {
    i = i->second.expired() ? trees.erase(i) : std::next(i);
  }
  auto tree = std::make_shared<const SegmentTree>(segments);
  trees.emplace(hash, tree);
  return tree;
}

SegmentTree::SegmentTree(const std::vector<Segment>& segments) : segments_(segments) {
  if (segments_.empty()) return;
  std::vector<uint32_t> places(segments_.size());
  std::iota(places.begin(), places.end(), 0);
  root_ = Build(places.begin(), places.end(), 0);
}

SegmentTree::Child SegmentTree::Build(Iterator begin, Iterator end, int depth) {
  Child child;
  for (Iterator i = begin; i != end; ++i) child.box.Add(segments_[*i]);
  if (end - begin <= kLeafSize) {
    child.index = AddLeaf(begin, end);
    return child;
  }
  child.index = static_cast<int32_t>(nodes_.size());
  nodes_.emplace_back();
  const Iterator middle = Split(begin, end, depth);
  const Child low = Build(begin, middle, depth + 1);
  const Child high = Build(middle, end, depth + 1);
  nodes_[child.index] = {{low, high}};
  return child;
}

int32_t SegmentTree::AddLeaf(Iterator begin, Iterator end) {
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
  return ~static_cast<int32_t>(leaves_.size() - 1);
}

/// Puts the walls of one child before those of the other; returns where the other's begin.
SegmentTree::Iterator SegmentTree::Split(Iterator begin, Iterator end, int depth) {
  Box centers;
  for (Iterator i = begin; i != end; ++i) {
    const Vec2 center = TwiceCenter(segments_[*i]);
    centers.Add(Segment{center, center});
  }
  // The walls are sorted into bins by their centres along an axis; a cut may lie between two bins.
  // A child costs as much as it is likely to be looked at, times the leaves that it will have.
  const auto bin_of = [&](uint32_t place, int axis) {
    const double from = Along(centers.low, axis);
    const double size = Along(centers.high, axis) - from;
    const double part = (Along(TwiceCenter(segments_[place]), axis) - from) / size;
    return std::min(kBins - 1, static_cast<int>(part * kBins));
  };
  const auto cost_of = [](const Box& box, int walls) {
    return walls == 0 ? 0.0 : box.half_perimeter() * ((walls + kLeafSize - 1) / kLeafSize);
  };
  double least_cost = std::numeric_limits<double>::infinity();
  int best_axis = 0;
  int best_cut = 0;
  for (int axis = 0; axis < 2 && depth < kMostCleverDepth; ++axis) {
    if (!(Along(centers.high, axis) > Along(centers.low, axis))) continue;
    Box boxes[kBins];
    int counts[kBins] = {};
    for (Iterator i = begin; i != end; ++i) {
      const int bin = bin_of(*i, axis);
      boxes[bin].Add(segments_[*i]);
      ++counts[bin];
    }
    double costs_above[kBins] = {};
    Box box;
    int count = 0;
    for (int cut = kBins - 1; cut > 0; --cut) {
      box.Add(boxes[cut]);
      count += counts[cut];
      costs_above[cut] = cost_of(box, count);
    }
    box = Box();
    count = 0;
    for (int cut = 1; cut < kBins; ++cut) {
      box.Add(boxes[cut - 1]);
      count += counts[cut - 1];
      const double cost = cost_of(box, count) + costs_above[cut];
      if (count == 0 || count == end - begin || cost >= least_cost) continue;
      least_cost = cost;
      best_axis = axis;
      best_cut = cut;
    }
  }
  if (best_cut > 0) {
    return std::partition(begin, end,
                          [&](uint32_t place) { return bin_of(place, best_axis) < best_cut; });
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
