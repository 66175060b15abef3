#include "world/saved_tree.hpp"

#include <algorithm>

#include "base/box2d_internals.hpp"

namespace flatland {
namespace {

/// Number of nodes to save: those after it were never in use, or are free in the same order.
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

/// `fixture`: the number of its fixture, if it is a leaf.
SavedTree::Node NodeOf(const b2TreeNode& node, int32 fixture, int32 used) {
  SavedTree::Node saved;
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

/// Checks a tree from its root down; `seen` are the nodes that were found.
bool IsTree(const std::vector<SavedTree::Node>& nodes, int32 root, size_t fixture_count,
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
    const SavedTree::Node& node = nodes[index];
    if (node.is_leaf()) {
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

SavedTree SavedTree::Of(b2World& world, const std::vector<b2Fixture*>& fixtures) {
  SavedTree saved;
  const b2TreeNode* const nodes = box2d::Nodes(world);
  const int32 used = UsedCount(nodes, box2d::NodeCapacity(world));
  saved.root = box2d::Root(world);
  saved.first_free = NextFree(box2d::FreeList(world), used);
  std::vector<int32> fixture_of(used);
  for (size_t i = 0; i < fixtures.size(); ++i) {
    fixture_of[box2d::FixtureInternals::Proxies(*fixtures[i])->proxyId] = static_cast<int32>(i);
  }
  saved.nodes.reserve(used);
  for (int32 i = 0; i < used; ++i) saved.nodes.push_back(NodeOf(nodes[i], fixture_of[i], used));
  const int32* const moves = box2d::Moves(world);
  saved.moves.assign(moves, moves + box2d::MoveCount(world));
  return saved;
}

bool SavedTree::IsSound(size_t fixture_count) const {
  const auto is_index = [this](int32 i) { return i >= 0 && i < node_count(); };
  std::vector<bool> seen(nodes.size());
  if (!IsTree(nodes, root, fixture_count, seen)) return false;
  for (int32 i = first_free; i != node_count(); i = nodes[i].parent) {
    if (!is_index(i) || seen[i] || nodes[i].height != -1) return false;
    seen[i] = true;
  }
  return std::all_of(seen.begin(), seen.end(), [](bool each) { return each; }) &&
         std::all_of(moves.begin(), moves.end(), [&](int32 i) {
           return i == b2_nullNode || (is_index(i) && nodes[i].is_leaf());
         });
}

void SavedTree::Restore(b2World& world, const std::vector<b2Fixture*>& fixtures) const {
  ReserveNodes(world, node_count());
  b2TreeNode* const to = box2d::Nodes(world);
  const int32 capacity = box2d::NodeCapacity(world);
  const auto to_free = [&](int32 i) { return i == capacity ? b2_nullNode : i; };
  int32 in_use = 0;
  for (int32 i = 0; i < node_count(); ++i) {
    const Node& from = nodes[i];
    b2TreeNode& node = to[i];
    node.aabb = from.box;
    node.userData = nullptr;
    node.parent = from.height < 0 ? to_free(from.parent) : from.parent;
    node.child1 = from.child1;
    node.child2 = from.child2;
    node.height = from.height;
    node.moved = from.moved;
    if (from.height >= 0) ++in_use;
    if (!from.is_leaf()) continue;
    b2FixtureProxy* const proxy = box2d::FixtureInternals::Proxies(*fixtures[from.child2]);
    node.child2 = b2_nullNode;
    node.userData = proxy;
    proxy->proxyId = i;
  }
  for (int32 i = node_count(); i < capacity; ++i) {
    to[i].next = to_free(i + 1);
    to[i].height = -1;
  }
  box2d::Root(world) = root;
  box2d::FreeList(world) = to_free(first_free);
  box2d::NodeCount(world) = in_use;
  SetMoves(world, moves);
}

}  // namespace flatland
