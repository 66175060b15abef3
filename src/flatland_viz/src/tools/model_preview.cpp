#include "model_preview.hpp"

#include <OgreSceneManager.h>
#include <OgreSceneNode.h>
#include <rviz/default_plugin/marker_utils.h>
#include <rviz/default_plugin/markers/marker_base.h>
#include <rviz/display_context.h>

namespace flatland_viz {
namespace {

constexpr float kPreviewZ = 0.1f;  // m: above the models in the world

}  // namespace

ModelPreview::ModelPreview(rviz::DisplayContext& context,
                           const visualization_msgs::MarkerArray& markers)
    : context_(context),
      node_(context.getSceneManager()->getRootSceneNode()->createChildSceneNode()) {
  for (visualization_msgs::Marker message : markers.markers) {
    std::unique_ptr<rviz::MarkerBase> marker(
        rviz::createMarker(message.type, nullptr, &context, node_));
    if (!marker) continue;
    // rviz transforms a marker into the fixed frame; a marker in that frame stays in its node's.
    message.header.frame_id = context.getFixedFrame().toStdString();
    message.header.stamp = ros::Time();
    marker->setMessage(message);
    markers_.push_back(std::move(marker));
  }
  node_->setVisible(false);
}

ModelPreview::~ModelPreview() {
  markers_.clear();
  context_.getSceneManager()->destroySceneNode(node_);
  context_.queueRender();
}

void ModelPreview::Place(const geometry_msgs::Pose2D& pose, const WorldPlane& world) {
  node_->setPosition(world.PositionInScene(pose, kPreviewZ));
  node_->setOrientation(world.OrientationInScene(pose));
  node_->setVisible(true);
  context_.queueRender();
}

}  // namespace flatland_viz
