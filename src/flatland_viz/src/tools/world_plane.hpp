#pragma once

/// The floor of the simulated world, as rviz shows it.

#include <OgreQuaternion.h>
#include <geometry_msgs/Pose2D.h>
#include <rviz/ogre_helpers/ogre_vector.h>

#include <optional>

namespace Ogre {
class Viewport;
}

namespace rviz {
class DisplayContext;
}

namespace flatland_viz {

/// rviz's scene is in the fixed frame, which may be another one than the world's.
class WorldPlane {
 public:
  static constexpr const char* kFrame = "map";

  /// Where the world is in the scene now; nothing if no transform tells.
  static std::optional<WorldPlane> Find(const rviz::DisplayContext& context);

  /// The point of the world [m] that is seen at a pixel of the window; its z is 0. Nothing where
  /// only the sky is seen.
  std::optional<Ogre::Vector3> PointAt(Ogre::Viewport* viewport, int x, int y) const;

  /// From the world into the scene. `height` is above the floor [m].
  Ogre::Vector3 PositionInScene(const geometry_msgs::Pose2D& pose, float height) const;
  Ogre::Quaternion OrientationInScene(const geometry_msgs::Pose2D& pose) const;

 private:
  Ogre::Vector3 origin_ = Ogre::Vector3::ZERO;
  Ogre::Quaternion orientation_ = Ogre::Quaternion::IDENTITY;
};

}  // namespace flatland_viz
