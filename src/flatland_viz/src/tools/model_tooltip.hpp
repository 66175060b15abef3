#pragma once

/// The tooltip of the model under the mouse: its name, pose and speed.

#include <ros/time.h>

class QWidget;

namespace flatland_viz {

struct WorldModel;

class ModelTooltip {
 public:
  /// The mouse has reached another model, or left it.
  void Restart();
  void Hide();
  /// Shows it beside the mouse when the mouse has been over a model for a while, and updates its
  /// text.
  void Update(const WorldModel& model, QWidget* panel);

 private:
  bool is_shown_ = false;
  ros::WallTime hovered_since_, updated_at_;
};

}  // namespace flatland_viz
