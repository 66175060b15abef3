#pragma once

/// The settings of a world: the numbers of its files that steps leave as they are, such as limits
/// of drives, ranges of lidars, and friction.
///
/// They are in an order that is the same in worlds of the same structure. So their indices name
/// them, in copies of a world, too.

#include <vector>

namespace flatland {

class World;

/// A setting at its place in a world.
struct Setting {
  double Get() const { return get(owner); }
  void Set(double value) const { set(owner, value); }

  void* owner;  ///< the number itself, or an object of Box2D that has it
  double (*get)(const void* owner);
  void (*set)(void* owner, double value);
  bool is_density = false;  ///< of a footprint: the mass of its body depends on it
};

/// All settings of a world, until something is added to it or removed. Those of layers, tweens,
/// joints and crowds are not among them. A body's mass does not follow a density.
std::vector<Setting> SettingsOf(World& world);

}  // namespace flatland
