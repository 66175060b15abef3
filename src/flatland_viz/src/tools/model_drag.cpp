#include "model_drag.hpp"

#include <ros/node_handle.h>
#include <ros/this_node.h>
#include <visualization_msgs/InteractiveMarkerFeedback.h>

#include <cmath>

#include "world_models.hpp"
#include "world_plane.hpp"

namespace flatland_viz {
namespace {

using Feedback = visualization_msgs::InteractiveMarkerFeedback;

const ros::WallDuration kKeepAlivePeriod(0.25);

}  // namespace

ModelDrag::ModelDrag()
    : feedback_(ros::NodeHandle().advertise<Feedback>("/interactive_model_markers/feedback", 100)) {
}

void ModelDrag::Begin(const std::string& model, const geometry_msgs::Pose2D& start,
                      const QPointF& at) {
  is_active_ = true;
  model_ = model;
  start_ = pose_ = start;
  grip_ = at;
  Send(Feedback::MOUSE_DOWN);
}

void ModelDrag::MoveTo(const QPointF& at) {
  pose_.x = start_.x + at.x() - grip_.x();
  pose_.y = start_.y + at.y() - grip_.y();
  Send(Feedback::POSE_UPDATE);
}

void ModelDrag::TurnTo(const QPointF& at, const QPointF& middle) {
  const QPointF before = grip_ - middle, now = at - middle;
  const double turn = std::atan2(now.y(), now.x()) - std::atan2(before.y(), before.x());
  pose_ = Compose(MakePose(middle.x(), middle.y(), turn),
                  MakePose(start_.x - middle.x(), start_.y - middle.y(), start_.theta));
  pose_.theta = std::remainder(pose_.theta, 2 * M_PI);
  Send(Feedback::POSE_UPDATE);
}

void ModelDrag::KeepAlive() {
  if (is_active_ && ros::WallTime::now() - sent_at_ > kKeepAlivePeriod) {
    Send(Feedback::KEEP_ALIVE);
  }
}

void ModelDrag::End() {
  if (!is_active_) return;
  Send(Feedback::MOUSE_UP);
  is_active_ = false;
}

void ModelDrag::Cancel() {
  pose_ = start_;
  End();
}

void ModelDrag::Send(std::uint8_t event) {
  sent_at_ = ros::WallTime::now();
  Feedback feedback;
  feedback.header.frame_id = WorldPlane::kFrame;
  feedback.client_id = ros::this_node::getName();
  feedback.marker_name = model_;
  feedback.control_name = "origin";  // of the model, not the marker's place
  feedback.event_type = event;
  feedback.pose.position.x = pose_.x;
  feedback.pose.position.y = pose_.y;
  feedback.pose.orientation.z = std::sin(pose_.theta / 2);
  feedback.pose.orientation.w = std::cos(pose_.theta / 2);
  feedback_.publish(feedback);
}

}  // namespace flatland_viz
