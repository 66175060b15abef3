#pragma once

#include <cstddef>
#include <cstdint>

namespace flatland {

/// Indices of walls that belong to something else.
struct WallList {
  const uint32_t* indices = nullptr;
  size_t count = 0;
};

}  // namespace flatland
