#include "world_plane.hpp"

#include <OgrePlane.h>
#include <rviz/display_context.h>
#include <rviz/geometry.h>

namespace flatland_viz {

std::optional<WorldPlane> WorldPlane::Find(const rviz::DisplayContext& context) {
  WorldPlane plane;
  if (context.getFixedFrame() == kFrame) return plane;  // needs no transform
  if (!context.getFrameManager()->getTransform(kFrame, ros::Time(), plane.origin_,
                                               plane.orientation_)) {
    return std::nullopt;
  }
  return plane;
}

std::optional<QPointF> WorldPlane::PointAt(Ogre::Viewport* viewport, int x, int y) const {
  Ogre::Plane floor(orientation_ * Ogre::Vector3::UNIT_Z, origin_);
  Ogre::Vector3 point;
  if (!rviz::getPointOnPlaneFromWindowXY(viewport, floor, x, y, point)) return std::nullopt;
  const Ogre::Vector3 in_world = orientation_.Inverse() * (point - origin_);
  return QPointF(in_world.x, in_world.y);
}

Ogre::Vector3 WorldPlane::PositionInScene(const geometry_msgs::Pose2D& pose, float height) const {
  const Ogre::Vector3 position(static_cast<float>(pose.x), static_cast<float>(pose.y), height);
  return origin_ + orientation_ * position;
}

Ogre::Quaternion WorldPlane::OrientationInScene(const geometry_msgs::Pose2D& pose) const {
  const Ogre::Radian yaw(static_cast<float>(pose.theta));
  return orientation_ * Ogre::Quaternion(yaw, Ogre::Vector3::UNIT_Z);
}

}  // namespace flatland_viz
