#pragma once

/// Drags a model, by the topic of the server's interactive markers.

#include <geometry_msgs/Pose2D.h>
#include <ros/publisher.h>
#include <ros/time.h>

#include <QPointF>
#include <string>

namespace flatland_viz {

/// The server pauses the simulation during a drag, and moves the model as it is told.
class ModelDrag {
 public:
  ModelDrag();

  bool is_active() const { return is_active_; }
  const std::string& model() const { return model_; }
  /// The pose of the model now.
  const geometry_msgs::Pose2D& pose() const { return pose_; }

  void Begin(const std::string& model, const geometry_msgs::Pose2D& start, const QPointF& at);
  /// Moves it with the mouse, which is at a point of the world [m].
  void MoveTo(const QPointF& at);
  /// Turns it about a point of the model, by the angle that the mouse has turned about that point.
  void TurnTo(const QPointF& at, const QPointF& middle);
  /// Must be called often: without messages, the server ends the drag.
  void KeepAlive();
  void End();
  /// Puts the model back.
  void Cancel();

 private:
  void Send(std::uint8_t event);

  ros::Publisher feedback_;
  bool is_active_ = false;
  std::string model_;
  geometry_msgs::Pose2D start_, pose_;
  QPointF grip_;  // where the mouse was at the beginning
  ros::WallTime sent_at_;
};

}  // namespace flatland_viz
