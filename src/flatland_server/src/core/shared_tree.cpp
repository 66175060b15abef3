/// The nodes that a move changes.
///
/// Box2D moves a leaf by taking it out of the tree and putting it in again, beside another node,
/// its new sibling. Both times it goes from there to the root, and at each node on its way it
/// updates that node and may rotate it: a child takes the node's place, and gives it one of its
/// children. So it writes to nodes on its way, and at most two levels below them.
///
/// - When the leaf is taken out, the way is along the leaf's ancestors.
/// - When it is put in, the way is along its new ancestors, in the tree that has been changed by
///   taking it out. That has changed the children of nodes at most one level below the old
///   ancestors, to nodes at most two levels below them. So in terms of the tree as it was before,
///   the new way consists of ancestors of the new sibling and of nodes at most one level below the
///   leaf's old ancestors, and what is written to is at most two levels below ancestors of the
///   sibling or three below those of the leaf.
/// - The sibling that the leaf has at the end is the one beside which it was put, a child of that,
///   or the sibling of that: rotations at the next two nodes of the way may change it, and no later
///   ones. Its ancestors, and the nodes below them, include those of the one beside which it was
///   put.
///
/// That holds for a single move. Box2D moves several fixtures in a step, and a fixture several
/// times when it finds times of impact. So moves are followed one by one: before a fixture is
/// moved, Box2D asks its shape for the bounding box, and the shapes of fixtures that move say so
/// here. If a move has yet been missed, which Box2D's count of insertions shows, all nodes are
/// compared.

#include "shared_tree.hpp"

#include <cstddef>
#include <cstring>
#include <new>

#include "box2d_internals.hpp"
#include "prefetch.hpp"

namespace flatland {
namespace {

/// Bit by bit, without the padding.
bool AreEqual(const b2TreeNode& a, const b2TreeNode& b) {
  constexpr size_t kWords = offsetof(b2TreeNode, moved) / sizeof(uint64_t);
  static_assert(kWords * sizeof(uint64_t) == offsetof(b2TreeNode, moved));
  uint64_t difference = a.moved != b.moved ? 1 : 0;
  for (size_t i = 0; i < kWords; ++i) {
    uint64_t words[2];
    std::memcpy(&words[0], reinterpret_cast<const std::byte*>(&a) + i * sizeof(uint64_t),
                sizeof(uint64_t));
    std::memcpy(&words[1], reinterpret_cast<const std::byte*>(&b) + i * sizeof(uint64_t),
                sizeof(uint64_t));
    difference |= words[0] ^ words[1];
  }
  return difference == 0;
}

bool AreEqual(const b2AABB& a, const b2AABB& b) { return std::memcmp(&a, &b, sizeof a) == 0; }

}  // namespace

thread_local SharedTree* SharedTree::entered_ = nullptr;

/// A shape that reports that it is going to be moved. It has the size of the one that it replaces,
/// so that Box2D can free it.
template <class Shape>
class SharedTree::Observed final : public Shape {
 public:
  explicit Observed(const Shape& shape) : Shape(shape) {
    static_assert(sizeof(Observed) == sizeof(Shape));
  }

  void ComputeAABB(b2AABB* box, const b2Transform& transform, int32 child) const override {
    if (entered_ != nullptr) entered_->Follow();
    Shape::ComputeAABB(box, transform, child);
  }
};

void SharedTree::Observe(b2Fixture& fixture) {
  b2Shape*& shape = box2d::FixtureInternals::Shape(fixture);
  const auto replace = [&shape](auto& old) {
    using Shape = std::remove_reference_t<decltype(old)>;
    const Shape copy = old;
    old.~Shape();
    shape = new (static_cast<void*>(&old)) Observed<Shape>(copy);
  };
  if (shape->GetType() == b2Shape::e_circle) {
    replace(static_cast<b2CircleShape&>(*shape));
  } else if (shape->GetType() == b2Shape::e_polygon) {
    replace(static_cast<b2PolygonShape&>(*shape));
  }
}

size_t SharedTree::CountNodes(b2World& world) {
  auto count = static_cast<size_t>(box2d::NodeCapacity(world));
  const b2TreeNode* const nodes = box2d::Nodes(world);
  while (count > 0 && nodes[count - 1].height < 0) --count;
  return count;
}

SharedTree::SharedTree(b2World& world, const std::vector<b2Fixture*>& moving,
                       std::vector<TreeChange>& changes)
    : world_(world), nodes_(box2d::Nodes(world)), insertions_(box2d::InsertionCount(world)) {
  for (b2Fixture* fixture : moving) {
    Observe(*fixture);
    const b2FixtureProxy* const proxies = box2d::FixtureInternals::Proxies(*fixture);
    const int32 count = box2d::FixtureInternals::ProxyCount(*fixture);
    for (int32 i = 0; i < count; ++i) moving_leaves_.push_back(proxies[i].proxyId);
  }
  const size_t count = CountNodes(world);
  is_changed_.resize(count);
  former_.reserve(count);
  for (size_t i = 0; i < count; ++i) {
    former_.push_back({nodes_[i], nodes_[i]});
    if (!nodes_[i].moved) continue;
    former_[i].beginning.moved = false;  // as after the first step
    changed_.push_back(static_cast<int32>(i));
  }
  Leave(changes);
}

SharedTree::~SharedTree() {
  if (entered_ == this) entered_ = nullptr;
}

void SharedTree::Prefetch(const std::vector<TreeChange>& changes) const {
  for (const TreeChange& each : changes) {
    PrefetchObject(nodes_[each.index]);
    PrefetchObject(former_[each.index]);
  }
}

void SharedTree::Enter(const std::vector<TreeChange>& changes) {
  for (const TreeChange& each : changes) {
    nodes_[each.index] = former_[each.index].before = each.node;
    is_changed_[each.index] = 1;
    changed_.push_back(each.index);
  }
  insertions_ = box2d::InsertionCount(world_);
  entered_ = this;
}

void SharedTree::Leave(std::vector<TreeChange>& changes) {
  Follow();
  changes.clear();
  for (const int32 index : changed_) {
    Former& former = former_[index];
    if (!AreEqual(nodes_[index], former.beginning)) changes.push_back({index, nodes_[index]});
    nodes_[index] = former.before = former.beginning;
    is_changed_[index] = 0;
  }
  changed_.clear();
  entered_ = nullptr;
}

void SharedTree::Follow() {
  const int32 moves = box2d::InsertionCount(world_) - insertions_;
  if (moves == 0) return;
  insertions_ += moves;
  int32 moved = b2_nullNode;
  bool is_clear = moves == 1;
  for (const int32 leaf : moving_leaves_) {
    if (AreEqual(nodes_[leaf].aabb, former_[leaf].before.aabb)) continue;
    is_clear = is_clear && moved == b2_nullNode;
    moved = leaf;
  }
  if (is_clear && moved != b2_nullNode) {
    FollowMove(moved);
  } else {
    CompareAll();
  }
  TakeFound();
}

void SharedTree::FollowMove(int32 leaf) {
  CompareAncestors(leaf, 3);
  const int32 parent = nodes_[leaf].parent;
  if (parent == b2_nullNode) return;
  const b2TreeNode& node = nodes_[parent];
  CompareAncestors(node.child1 == leaf ? node.child2 : node.child1, 2);
}

void SharedTree::CompareAll() {
  ++comparisons_;
  for (size_t i = 0; i < size(); ++i) Compare(static_cast<int32>(i), 0);
}

void SharedTree::CompareAncestors(int32 index, int levels) {
  Compare(index, levels);
  int32 below = index;
  for (int32 i = former_[index].before.parent; i != b2_nullNode; i = former_[i].before.parent) {
    const b2TreeNode& node = former_[i].before;
    Compare(i, 0);
    Compare(node.child1 == below ? node.child2 : node.child1, levels - 1);
    below = i;
  }
}

void SharedTree::Compare(int32 index, int levels) {
  const b2TreeNode& node = former_[index].before;
  if (!AreEqual(node, nodes_[index])) found_.push_back(index);
  if (levels == 0 || node.IsLeaf()) return;
  Compare(node.child1, levels - 1);
  Compare(node.child2, levels - 1);
}

void SharedTree::TakeFound() {
  for (const int32 index : found_) {
    former_[index].before = nodes_[index];
    if (is_changed_[index] != 0) continue;
    is_changed_[index] = 1;
    changed_.push_back(index);
  }
  found_.clear();
}

}  // namespace flatland
