#pragma once

/// The areas within outlines of walls, as triangles.

#include <vector>

namespace flatland_viz {

/// Divides the areas within closed outlines into triangles, by the even-odd rule. Lines that are
/// part of no closed outline are ignored.
///
/// @param segments  x1, y1, x2, y2 of each line [m]; lines may touch, but not cross
/// @return x, y of the corners, three for a triangle [m]
std::vector<float> FillOf(const std::vector<float>& segments);

}  // namespace flatland_viz
