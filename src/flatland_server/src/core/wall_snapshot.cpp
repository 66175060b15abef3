#include "wall_snapshot.hpp"

#include <utility>

#include "box2d_internals.hpp"

namespace flatland {

WallSnapshot::WallSnapshot(b2World& world, std::vector<Layers::Layer> layers)
    : layers_(std::move(layers)),
      nodes_(box2d::Nodes(world), box2d::Nodes(world) + box2d::NodeCount(world)),
      root_(box2d::Root(world)),
      insertions_(box2d::InsertionCount(world)) {}

void WallSnapshot::Restore(b2World& world) const {
  b2TreeNode* const nodes = box2d::Nodes(world);
  const auto used = static_cast<int32>(nodes_.size());
  for (int32 i = 0; i < used; ++i) {
    void* const wall = nodes[i].userData;
    nodes[i] = nodes_[i];
    if (nodes[i].IsLeaf()) nodes[i].userData = wall;
  }
  const int32 capacity = box2d::NodeCapacity(world);
  for (int32 i = used; i < capacity; ++i) {
    nodes[i].height = -1;
    nodes[i].next = i + 1 < capacity ? i + 1 : b2_nullNode;
  }
  box2d::FreeList(world) = used < capacity ? used : b2_nullNode;
  box2d::NodeCount(world) = used;
  box2d::Root(world) = root_;
  box2d::InsertionCount(world) = insertions_;
  box2d::MoveCount(world) = 0;
  box2d::NewContacts(world) = true;
  box2d::InverseStep(world) = 0.0f;
}

}  // namespace flatland
