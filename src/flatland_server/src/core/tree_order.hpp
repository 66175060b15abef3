#pragma once

/// The order in memory of the nodes of Box2D's tree of bounding boxes.
///
/// Box2D numbers nodes as it needs them, so the path from the root to a leaf is all over the array.
/// The processor's caches hold more of what is needed if a path is in few pages: the upper levels
/// in one or two, and each subtree below in another one.

#include <box2d/box2d.h>

namespace flatland::box2d {

/// Renumbers the nodes of a tree of walls. No step changes: two walls have no contact, so the order
/// of their numbers does not matter.
void OrderNodes(b2DynamicTree& tree);
/// The same in a world with nothing but walls.
void OrderNodes(b2World& world);

/// True if a leaf is a wall, rather than a fixture of a body.
bool IsWall(const b2TreeNode& leaf);

}  // namespace flatland::box2d
