#pragma once

/// The relation between the scene and the pixels of the screen.

#include <OgreQuaternion.h>
#include <OgreVector.h>

namespace flatland_viz {

/// The scale of a camera at a point of the scene, in device pixels.
struct ScreenScale {
  double pixels_per_metre = 1.0;
  Ogre::Quaternion camera = Ogre::Quaternion::IDENTITY;  ///< its orientation

  static ScreenScale At(const Ogre::Vector3& point, const Ogre::Viewport& viewport);

  float Metres(double pixels) const { return static_cast<float>(pixels / pixels_per_metre); }
  /// The vector in the scene of so many pixels to the right and upwards on the screen.
  Ogre::Vector3 Offset(double right, double up) const {
    return camera * Ogre::Vector3(Metres(right), Metres(up), 0);
  }
};

/// The position of a point on the screen, from the middle of the viewport to the right and upwards
/// [pixels].
Ogre::Vector2 OnScreen(const Ogre::Vector3& point, const Ogre::Viewport& viewport);

/// A position near `point` at which a picture of an even number of pixels is not blurred.
Ogre::Vector3 OnPixels(const Ogre::Vector3& point, const Ogre::Viewport& viewport);

}  // namespace flatland_viz
