#include "screen_scale.hpp"

#include <OgreCamera.h>
#include <OgreMatrix4.h>
#include <OgreViewport.h>

#include <cmath>

namespace flatland_viz {

Ogre::Vector2 OnScreen(const Ogre::Vector3& point, const Ogre::Viewport& viewport) {
  const Ogre::Camera& camera = *viewport.getCamera();
  const Ogre::Vector3 projected = camera.getProjectionMatrix() * (camera.getViewMatrix() * point);
  return {0.5f * projected.x * static_cast<float>(viewport.getActualWidth()),
          0.5f * projected.y * static_cast<float>(viewport.getActualHeight())};
}

ScreenScale ScreenScale::At(const Ogre::Vector3& point, const Ogre::Viewport& viewport) {
  ScreenScale scale;
  scale.camera = viewport.getCamera()->getDerivedOrientation();
  const Ogre::Vector3 beside = point + scale.camera * Ogre::Vector3::UNIT_X;
  const double pixels = (OnScreen(beside, viewport) - OnScreen(point, viewport)).length();
  if (std::isfinite(pixels) && pixels > 1e-6) scale.pixels_per_metre = pixels;
  return scale;
}

Ogre::Vector3 OnPixels(const Ogre::Vector3& point, const Ogre::Viewport& viewport) {
  const ScreenScale scale = ScreenScale::At(point, viewport);
  const Ogre::Vector2 at = OnScreen(point, viewport);
  // The middle of the viewport is between two pixels only if the number of pixels is even.
  const double x = 0.5 * (viewport.getActualWidth() % 2),
               y = 0.5 * (viewport.getActualHeight() % 2);
  return point + scale.Offset(std::round(at.x - x) + x - at.x, std::round(at.y - y) + y - at.y);
}

}  // namespace flatland_viz
