#pragma once

/// The preview of a model that is about to be spawned.

#include <geometry_msgs/Pose2D.h>
#include <visualization_msgs/MarkerArray.h>

#include <memory>
#include <vector>

#include "world_plane.hpp"

namespace rviz {
class DisplayContext;
class MarkerBase;
}  // namespace rviz

namespace flatland_viz {

/// Visible from the first `Place` until it is destroyed.
class ModelPreview {
 public:
  /// `markers` are in the model's own frame.
  ModelPreview(rviz::DisplayContext& context, const visualization_msgs::MarkerArray& markers);
  ~ModelPreview();
  ModelPreview(const ModelPreview&) = delete;
  ModelPreview& operator=(const ModelPreview&) = delete;

  void Place(const geometry_msgs::Pose2D& pose, const WorldPlane& world);

 private:
  rviz::DisplayContext& context_;
  Ogre::SceneNode* node_;  // belongs to the scene; removed from it at the end
  std::vector<std::unique_ptr<rviz::MarkerBase>> markers_;
};

}  // namespace flatland_viz
