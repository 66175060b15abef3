#include "saved_tree.hpp"

#include <algorithm>
#include <cstring>
#include <mutex>

#include "archive.hpp"
#include "box2d_internals.hpp"
#include "tree_order.hpp"

namespace flatland {
namespace {

bool AreEqual(const b2AABB& a, const b2AABB& b) { return std::memcmp(&a, &b, sizeof a) == 0; }

/// The one that was made last, and its lock.
std::weak_ptr<const WallTree> latest;
std::mutex latest_mutex;

/// Number of nodes before those that were never in use, or are free in the same order.
int32 UsedCount(const b2TreeNode* nodes, int32 capacity) {
  int32 count = capacity;
  while (count > 0) {
    const b2TreeNode& last = nodes[count - 1];
    if (last.height >= 0 || last.next != (count == capacity ? b2_nullNode : count)) break;
    --count;
  }
  return count;
}

/// The index of the next free node, which is `used` for all those that were never in use.
int32 NextFree(int32 next, int32 used) { return next == b2_nullNode || next > used ? used : next; }

/// `fixture` is that of a leaf.
SavedNode NodeOf(const b2TreeNode& node, int32 fixture, int32 used) {
  SavedNode saved;
  saved.height = node.height;
  saved.parent = node.parent;
  if (node.height < 0) {
    saved.parent = NextFree(node.next, used);
    return saved;
  }
  saved.box = node.aabb;
  saved.child1 = node.child1;
  saved.child2 = node.IsLeaf() ? fixture : node.child2;
  saved.moved = node.moved;
  return saved;
}

bool IsLeaf(const SavedNode& node) { return node.height == 0; }

/// Checks a tree from its root down; `seen` are the nodes that were found.
bool IsTree(const std::vector<SavedNode>& nodes, int32 root, size_t fixture_count,
            std::vector<bool>& seen) {
  const auto count = static_cast<int32>(nodes.size());
  std::vector<bool> has_leaf(fixture_count);
  size_t leaves = 0;
  std::vector<int32> stack;
  const auto push = [&](int32 index, int32 parent) {
    if (index < 0 || index >= count || seen[index] || nodes[index].parent != parent) return false;
    seen[index] = true;
    stack.push_back(index);
    return true;
  };
  if (root == b2_nullNode) return fixture_count == 0;
  if (!push(root, b2_nullNode)) return false;
  while (!stack.empty()) {
    const int32 index = stack.back();
    stack.pop_back();
    const SavedNode& node = nodes[index];
    if (IsLeaf(node)) {
      const int32 fixture = node.child2;
      if (node.child1 != b2_nullNode || fixture < 0) return false;
      if (static_cast<size_t>(fixture) >= fixture_count || has_leaf[fixture]) return false;
      has_leaf[fixture] = true;
      ++leaves;
      continue;
    }
    if (!push(node.child1, index) || !push(node.child2, index)) return false;
    const int32 below = std::max(nodes[node.child1].height, nodes[node.child2].height);
    if (below < 0 || node.height != below + 1) return false;
  }
  return leaves == fixture_count;
}

/// Makes room for so many nodes, as Box2D does: by doubling.
void ReserveNodes(b2World& world, int32 count) {
  int32 capacity = box2d::NodeCapacity(world);
  if (count <= capacity) return;
  while (capacity < count) capacity *= 2;
  auto* const nodes = static_cast<b2TreeNode*>(
      b2Alloc(static_cast<int32>(static_cast<size_t>(capacity) * sizeof(b2TreeNode))));
  b2Free(box2d::Nodes(world));
  box2d::Nodes(world) = nodes;
  box2d::NodeCapacity(world) = capacity;
}

void SetMoves(b2World& world, const std::vector<int32>& moves) {
  int32& capacity = box2d::MoveCapacity(world);
  const auto count = static_cast<int32>(moves.size());
  if (count > capacity) {
    while (capacity < count) capacity *= 2;
    b2Free(box2d::Moves(world));
    box2d::Moves(world) = static_cast<int32*>(
        b2Alloc(static_cast<int32>(static_cast<size_t>(capacity) * sizeof(int32))));
  }
  std::copy(moves.begin(), moves.end(), box2d::Moves(world));
  box2d::MoveCount(world) = count;
}

}  // namespace

bool SavedNode::operator==(const SavedNode& other) const {
  return parent == other.parent && child1 == other.child1 && child2 == other.child2 &&
         height == other.height && moved == other.moved && AreEqual(box, other.box);
}

bool WallTree::IsOf(const Boxes& boxes) const {
  return std::equal(boxes_.begin(), boxes_.end(), boxes.begin(), boxes.end(),
                    [](const auto& a, const auto& b) {
                      return std::equal(a.begin(), a.end(), b.begin(), b.end(), AreEqual);
                    });
}

std::shared_ptr<const WallTree> WallTree::Of(Boxes boxes,
                                             const std::shared_ptr<const WallTree>& present) {
  if (present != nullptr && present->IsOf(boxes)) return present;
  std::shared_ptr<const WallTree> last = Latest(boxes);
  if (last != nullptr) return last;
  auto made = std::make_shared<const WallTree>(std::move(boxes));
  const std::lock_guard<std::mutex> lock(latest_mutex);
  latest = made;
  return made;
}

std::shared_ptr<const WallTree> WallTree::Latest(const Boxes& boxes) {
  std::shared_ptr<const WallTree> last;
  {
    const std::lock_guard<std::mutex> lock(latest_mutex);
    last = latest.lock();
  }
  return last != nullptr && last->IsOf(boxes) ? last : nullptr;
}

void WallTree::PutInto(b2World& world, const std::vector<b2Fixture*>& fixtures) const {
  SavedTree tree;
  tree.node_count = tree.first_free = static_cast<int32>(nodes_.size());
  const auto is_root = [](const SavedNode& node) {
    return node.height >= 0 && node.parent == b2_nullNode;
  };
  const auto root = std::find_if(nodes_.begin(), nodes_.end(), is_root);
  if (root != nodes_.end()) tree.root = static_cast<int32>(root - nodes_.begin());
  tree.Restore(world, fixtures, *this);
}

WallTree::WallTree(Boxes boxes) : boxes_(std::move(boxes)) {
  b2DynamicTree tree;
  uintptr_t count = 0;
  for (const std::vector<b2AABB>& layer : boxes_) {
    for (const b2AABB& box : layer) tree.CreateProxy(box, reinterpret_cast<void*>(count++));
    box2d::OrderNodes(tree);
    const auto* const bytes = reinterpret_cast<const char*>(layer.data());
    const uint64_t sum = Checksum({bytes, layer.size() * sizeof(b2AABB)});
    checksum_ = checksum_ * 31 + static_cast<uint32_t>(sum);
  }
  const b2TreeNode* const nodes = box2d::Nodes(tree);
  const int32 used = UsedCount(nodes, box2d::NodeCapacity(tree));
  for (int32 i = 0; i < used; ++i) {
    const auto wall = static_cast<int32>(reinterpret_cast<uintptr_t>(nodes[i].userData));
    nodes_.push_back(NodeOf(nodes[i], wall, used));
    nodes_.back().moved = false;
  }
}

SavedTree SavedTree::Of(b2World& world, const std::vector<b2Fixture*>& fixtures,
                        const WallTree& walls) {
  SavedTree saved;
  const b2TreeNode* const nodes = box2d::Nodes(world);
  const int32 capacity = box2d::NodeCapacity(world);
  saved.node_count = UsedCount(nodes, capacity);
  saved.root = box2d::Root(world);
  saved.first_free = NextFree(box2d::FreeList(world), saved.node_count);
  std::vector<int32> fixture_of(saved.size());
  for (size_t i = 0; i < fixtures.size(); ++i) {
    fixture_of[box2d::FixtureInternals::Proxies(*fixtures[i])->proxyId] = static_cast<int32>(i);
  }
  const std::vector<SavedNode>& beginning = walls.nodes();
  for (int32 i = 0; i < saved.node_count; ++i) {
    const SavedNode node = NodeOf(nodes[i], fixture_of[i], saved.node_count);
    if (static_cast<size_t>(i) >= beginning.size() || !(node == beginning[i])) {
      saved.changes.push_back({i, node});
    }
  }
  const int32* const moves = box2d::Moves(world);
  saved.moves.assign(moves, moves + box2d::MoveCount(world));
  return saved;
}

std::vector<SavedNode> SavedTree::Nodes(const WallTree& walls) const {
  std::vector<SavedNode> nodes = walls.nodes();
  nodes.resize(size());
  for (const Change& each : changes) nodes[each.index] = each.node;
  return nodes;
}

bool SavedTree::IsSound(size_t fixture_count, const WallTree& walls) const {
  // Each node beyond those of the walls is a change.
  if (node_count < 0 || size() > walls.nodes().size() + changes.size()) return false;
  const auto is_index = [this](int32 i) { return i >= 0 && i < node_count; };
  const auto is_outside = [&](const Change& each) { return !is_index(each.index); };
  if (std::any_of(changes.begin(), changes.end(), is_outside)) return false;
  const std::vector<SavedNode> nodes = Nodes(walls);
  std::vector<bool> seen(nodes.size());
  if (!IsTree(nodes, root, fixture_count, seen)) return false;
  for (int32 i = first_free; i != node_count; i = nodes[i].parent) {
    if (!is_index(i) || seen[i] || nodes[i].height != -1) return false;
    seen[i] = true;
  }
  return std::all_of(seen.begin(), seen.end(), [](bool each) { return each; }) &&
         std::all_of(moves.begin(), moves.end(), [&](int32 i) {
           return i == b2_nullNode || (is_index(i) && IsLeaf(nodes[i]));
         });
}

void SavedTree::Restore(b2World& world, const std::vector<b2Fixture*>& fixtures,
                        const WallTree& walls) const {
  ReserveNodes(world, node_count);
  b2TreeNode* const nodes = box2d::Nodes(world);
  const int32 capacity = box2d::NodeCapacity(world);
  const auto to_free = [&](int32 i) { return i == capacity ? b2_nullNode : i; };
  int32 in_use = 0;
  const std::vector<SavedNode> saved = Nodes(walls);
  for (int32 i = 0; i < node_count; ++i) {
    const SavedNode& from = saved[i];
    b2TreeNode& node = nodes[i];
    node.aabb = from.box;
    node.userData = nullptr;
    node.parent = from.height < 0 ? to_free(from.parent) : from.parent;
    node.child1 = from.child1;
    node.child2 = from.child2;
    node.height = from.height;
    node.moved = from.moved;
    if (from.height >= 0) ++in_use;
    if (!IsLeaf(from)) continue;
    b2FixtureProxy* const proxy = box2d::FixtureInternals::Proxies(*fixtures[from.child2]);
    node.child2 = b2_nullNode;
    node.userData = proxy;
    proxy->proxyId = i;
  }
  for (int32 i = node_count; i < capacity; ++i) {
    nodes[i].next = to_free(i + 1);
    nodes[i].height = -1;
  }
  box2d::Root(world) = root;
  box2d::FreeList(world) = to_free(first_free);
  box2d::NodeCount(world) = in_use;
  box2d::InsertionCount(world) += 2;  // more than one leaf may have moved; see SharedTree
  SetMoves(world, moves);
}

}  // namespace flatland
