#include "tree_order.hpp"

#include <algorithm>
#include <cstdint>
#include <vector>

#include "box2d_internals.hpp"

namespace flatland::box2d {
namespace {

/// Nodes of the upper levels that are placed level by level: as many as two pages of 4 KiB hold.
constexpr size_t kUpperNodes = 2 * 4096 / sizeof(b2TreeNode);

/// All nodes below `root`: the upper ones by levels, then one subtree after the other.
std::vector<int32> Traverse(const b2TreeNode* nodes, int32 root) {
  std::vector<int32> order{root};
  size_t next = 0;
  for (; next < order.size() && order.size() + 2 <= kUpperNodes; ++next) {
    const b2TreeNode& node = nodes[order[next]];
    if (node.IsLeaf()) continue;
    order.push_back(node.child1);
    order.push_back(node.child2);
  }
  // Nodes from `next` on have children that are not yet in the order.
  const std::vector<int32> subtrees(order.begin() + static_cast<ptrdiff_t>(next), order.end());
  for (const int32 subtree : subtrees) {
    std::vector<int32> stack;
    const auto push_children = [&](int32 index) {
      if (nodes[index].IsLeaf()) return;
      stack.push_back(nodes[index].child2);
      stack.push_back(nodes[index].child1);
    };
    push_children(subtree);
    while (!stack.empty()) {
      const int32 index = stack.back();
      stack.pop_back();
      order.push_back(index);
      push_children(index);
    }
  }
  return order;
}

}  // namespace

bool IsWall(const b2TreeNode& leaf) {
  return static_cast<const b2FixtureProxy*>(leaf.userData)->fixture->GetType() == b2Shape::e_edge;
}

void OrderNodes(b2DynamicTree& tree) {
  int32& root = Root(tree);
  if (root == b2_nullNode) return;
  b2TreeNode* const nodes = Nodes(tree);
  const std::vector<int32> order = Traverse(nodes, root);
  std::vector<int32> places = order;
  std::sort(places.begin(), places.end());

  const std::vector<b2TreeNode> old(nodes, nodes + places.back() + 1);
  std::vector<int32> renumbered(old.size());
  for (size_t i = 0; i < order.size(); ++i) renumbered[order[i]] = places[i];
  const auto renumber = [&](int32& index) {
    if (index != b2_nullNode) index = renumbered[index];
  };
  for (size_t i = 0; i < order.size(); ++i) {
    b2TreeNode& node = nodes[places[i]] = old[order[i]];
    renumber(node.parent);
    renumber(node.child1);
    renumber(node.child2);
  }
  renumber(root);
}

void OrderNodes(b2World& world) {
  OrderNodes(Tree(world));
  const b2TreeNode* const nodes = Nodes(world);
  for (int32 i = 0; i < NodeCapacity(world); ++i) {
    if (nodes[i].height == 0) static_cast<b2FixtureProxy*>(nodes[i].userData)->proxyId = i;
  }
}

}  // namespace flatland::box2d
