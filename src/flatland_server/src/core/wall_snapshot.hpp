#pragma once

/// The layers of a world that has nothing else yet, and Box2D's tree of bounding boxes of them.
///
/// Need. Programs that learn reset a world thousands of times. In an office, making its walls again
/// took half of a reset: 1.3 ms, nearly all of it for putting them into the tree one by one.
///
/// Method. A world that is replaced keeps its walls for the one after the next. Everything else is
/// removed from it, and the tree becomes that of the snapshot: the same nodes, and free nodes in
/// the same order as in a new tree. Box2D finds contacts in the order of the tree and of the
/// numbers of its nodes, never in that of addresses, so that steps are the same bit for bit. Leaves
/// of walls keep their nodes while a world exists, so that a snapshot serves all worlds of the same
/// layers.

#include <box2d/box2d.h>

#include <cstddef>
#include <vector>

#include "layers.hpp"

namespace flatland {

class WallSnapshot {
 public:
  /// Box2D's world has these layers alone.
  WallSnapshot(b2World& world, std::vector<Layers::Layer> layers);

  const std::vector<Layers::Layer>& layers() const { return layers_; }
  /// Gives the tree back to a world of these layers, from which all else has been removed.
  void Restore(b2World& world) const;

 private:
  std::vector<Layers::Layer> layers_;
  std::vector<b2TreeNode> nodes_;  // as they were, but for the addresses of the walls in leaves
  int32 root_;
  int32 insertions_;
};

}  // namespace flatland
