#pragma once

/// What people avoid: the walls of layers, and bodies.

#include <box2d/box2d.h>

#include <functional>
#include <vector>

#include "base/collision_layers.hpp"
#include "people/social_force.hpp"
#include "world/bodies.hpp"
#include "world/layers.hpp"

namespace flatland {

/// A body's fixtures that can be touched on some layers.
struct Outline {
  b2Body* body = nullptr;
  std::vector<const b2Shape*> shapes;
  bool is_robot = false;  // a dynamic body that is no person

  /// The nearest point of a body that is at `pose`, as seen from a point of the world: its distance
  /// [m], and the direction away from it.
  Obstacle SeenFrom(Vec2 point, Vec2 position, const Rotation& heading) const;
};

/// The outlines of the bodies that can be touched on these layers, without walls and without the
/// bodies for which `is_left_out` is true.
std::vector<Outline> FindOutlines(const Bodies& bodies, LayerBits layers,
                                  const std::function<bool(Bodies::Body)>& is_left_out);

/// Replaces `seen` by the walls around a point that are no farther than `reach` [m]: the nearest
/// point of them on up to four sides. One point of a wall repels, however many pieces the wall is
/// made of; but both walls of a corridor repel, and both corners of a door. `found` is a buffer.
void SeeWalls(const Layers& all, LayerBits layers, Vec2 point, double reach,
              std::vector<Obstacle>& found, std::vector<Obstacle>& seen);

}  // namespace flatland
