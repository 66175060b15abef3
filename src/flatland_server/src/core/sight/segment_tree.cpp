#include "sight/segment_tree.hpp"

#include <algorithm>
#include <cstddef>
#include <limits>
#include <numeric>

namespace flatland {
namespace {

/// Boxes are enlarged by this fraction of the tree's size, since coordinates and the position of
/// the lidar are in single precision.
constexpr double kRounding = 4e-7;
/// Rounding matters within a distance of this fraction of the half perimeter of a leaf.
constexpr double kNear = 0.05;
/// The top level has no more nodes than this.
constexpr size_t kMostAtTop = 4;

Vec2 TwiceCenter(const Segment& segment) { return segment.a + segment.b; }

}  // namespace

SegmentTree::SegmentTree(std::vector<Segment> segments, const Progress& progress)
    : segments_(std::move(segments)) {
  if (segments_.empty()) return;
  std::vector<uint32_t> order(segments_.size());
  std::iota(order.begin(), order.end(), 0);
  const Iterator begin = order.begin(), end = order.end();
  size_t done = 0;
  Arrange(begin, end, progress, &done);
  const Box all = BoxOf(begin, end);
  center_ = 0.5 * (all.low + all.high);
  margin_ = kRounding * std::max(all.high.x - center_.x, all.high.y - center_.y);
  std::vector<Box> boxes;
  for (Iterator i = begin; i < end;) {
    const Iterator next = i + std::min<ptrdiff_t>(kWidth, end - i);
    boxes.push_back(BoxOf(i, next));
    leaves_.push_back(MakeLeaf(i, next, boxes.back()));
    i = next;
  }
  do {
    levels_.push_back(MakeLevel(boxes));
    std::vector<Box> above(levels_.back().size());
    for (size_t i = 0; i < boxes.size(); ++i) above[i / kWidth].Add(boxes[i]);
    boxes = std::move(above);
  } while (boxes.size() > kMostAtTop);
}

Box SegmentTree::BoxOf(Iterator begin, Iterator end) const {
  Box box;
  for (Iterator i = begin; i != end; ++i) box.Add(segments_[*i]);
  return box;
}

/// Sorts walls such that those of each leaf, and of each node, are near each other.
void SegmentTree::Arrange(Iterator begin, Iterator end, const Progress& progress,
                          size_t* done) const {
  if (end - begin <= kWidth) {
    const size_t before = *done;
    *done += static_cast<size_t>(end - begin);
    const bool is_due = before / kProgressStep != *done / kProgressStep;
    if (progress && (is_due || *done == segments_.size())) progress(*done);
    return;
  }
  ptrdiff_t unit = kWidth;
  while (unit * kWidth < end - begin) unit *= kWidth;
  const Iterator middle = begin + ((end - begin + unit - 1) / unit + 1) / 2 * unit;
  const auto divide = [&](auto along) {
    std::nth_element(begin, middle, end, [&](uint32_t a, uint32_t b) {
      return along(TwiceCenter(segments_[a])) < along(TwiceCenter(segments_[b]));
    });
    return BoxOf(begin, middle).half_perimeter() * static_cast<double>(middle - begin) +
           BoxOf(middle, end).half_perimeter() * static_cast<double>(end - middle);
  };
  const auto x = [](Vec2 v) { return v.x; };
  const auto y = [](Vec2 v) { return v.y; };
  if (divide(x) < divide(y)) divide(x);
  Arrange(begin, middle, progress, done);
  Arrange(middle, end, progress, done);
}

SegmentTree::Leaf SegmentTree::MakeLeaf(Iterator begin, Iterator end, const Box& box) const {
  Leaf leaf;
  leaf.center = 0.5 * (box.low + box.high);
  const double near = kNear * box.half_perimeter();
  leaf.near_square = static_cast<float>(near * near);
  for (float* values : {leaf.ax, leaf.ay, leaf.bx, leaf.by}) {
    std::fill_n(values, kWidth, std::numeric_limits<float>::quiet_NaN());
  }
  std::fill(std::copy(begin, end, leaf.indices), leaf.indices + kWidth, *(end - 1));
  for (int i = 0; i < end - begin; ++i) {
    const Segment& wall = segments_[leaf.indices[i]];
    leaf.ax[i] = static_cast<float>(wall.a.x - leaf.center.x);
    leaf.ay[i] = static_cast<float>(wall.a.y - leaf.center.y);
    leaf.bx[i] = static_cast<float>(wall.b.x - leaf.center.x);
    leaf.by[i] = static_cast<float>(wall.b.y - leaf.center.y);
  }
  return leaf;
}

/// The nodes that have these boxes as children.
std::vector<SegmentTree::Node> SegmentTree::MakeLevel(const std::vector<Box>& boxes) const {
  std::vector<Node> nodes((boxes.size() + kWidth - 1) / kWidth);
  for (Node& node : nodes) {
    for (float* values : {node.low_x, node.low_y, node.high_x, node.high_y}) {
      std::fill_n(values, kWidth, std::numeric_limits<float>::infinity());
    }
  }
  for (size_t i = 0; i < boxes.size(); ++i) {
    Node& node = nodes[i / kWidth];
    const size_t k = i % kWidth;
    node.low_x[k] = static_cast<float>(boxes[i].low.x - center_.x - margin_);
    node.low_y[k] = static_cast<float>(boxes[i].low.y - center_.y - margin_);
    node.high_x[k] = static_cast<float>(boxes[i].high.x - center_.x + margin_);
    node.high_y[k] = static_cast<float>(boxes[i].high.y - center_.y + margin_);
  }
  return nodes;
}

}  // namespace flatland
