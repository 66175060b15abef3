#pragma once

/// Collision layers: they decide which fixtures collide, and which ones a lidar sees.

#include <cstdint>

namespace flatland {

/// A set of up to 16 collision layers, one bit each.
using LayerBits = uint16_t;

constexpr LayerBits kAllLayers = 0xFFFF;

}  // namespace flatland
