#pragma once

/// Numbers that are not finite.

#include <limits>

namespace flatland {

inline constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
inline constexpr double kInfinity = std::numeric_limits<double>::infinity();

}  // namespace flatland
