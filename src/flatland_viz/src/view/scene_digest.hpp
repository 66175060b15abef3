#pragma once

/// A number that changes when a picture of the scene would.

#include <OgrePrerequisites.h>

#include <cstdint>

namespace flatland_viz {

/// A hash of what a window shows: its viewports and cameras, and of each visible object its place,
/// materials and geometry.
///
/// rviz does not say when its displays have changed something, so this looks at the result. It
/// reads what is at hand in memory: a few samples of long lines, and of other geometry the buffers'
/// addresses, sizes and bounds, since the vertices may be on the graphics card. Most displays make
/// new buffers for new content. A change within the same buffer, bounds and number of vertices is
/// missed.
std::uint64_t DigestOfScene(const Ogre::RenderWindow& window);

}  // namespace flatland_viz
