#pragma once

/// The floor of the simulated world in rviz's scene.

#include <OgreQuaternion.h>
#include <geometry_msgs/Pose2D.h>
#include <rviz/ogre_helpers/ogre_vector.h>

#include <QPointF>
#include <optional>

namespace rviz {
class DisplayContext;
}

namespace flatland_viz {

/// rviz's scene is in its fixed frame, which may differ from the world's.
class WorldPlane {
 public:
  static constexpr const char* kFrame = "map";

  /// The present pose of the world in the scene; nothing without a transform.
  static std::optional<WorldPlane> Find(const rviz::DisplayContext& context);

  /// The point of the floor at a pixel of the window, in the world [m]. Nothing above the
  /// horizon.
  std::optional<QPointF> PointAt(Ogre::Viewport* viewport, int x, int y) const;

  /// Transforms from the world into the scene. `height` is above the floor [m].
  Ogre::Vector3 PositionInScene(const geometry_msgs::Pose2D& pose, float height) const;
  Ogre::Quaternion OrientationInScene(const geometry_msgs::Pose2D& pose) const;

 private:
  Ogre::Vector3 origin_ = Ogre::Vector3::ZERO;
  Ogre::Quaternion orientation_ = Ogre::Quaternion::IDENTITY;
};

}  // namespace flatland_viz
