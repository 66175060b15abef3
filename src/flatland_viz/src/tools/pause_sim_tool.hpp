#pragma once

/// rviz's button that pauses and resumes the simulation.

#include <flatland_msgs/SimulationState.h>
#include <ros/subscriber.h>
#include <rviz/tool.h>

#include <QIcon>
#include <QPointer>
#include <optional>

#include "service_caller.hpp"

namespace flatland_viz {

/// Its name and icon show what a click does: "Pause" or "Resume". It acts once when its button or
/// key is pressed, however long that is held, and hands back to the previous tool at once.
class PauseSimTool : public rviz::Tool {
 public:
  PauseSimTool() { shortcut_key_ = ' '; }

  void activate() override;
  void deactivate() override {}

  /// True while it hands back: the tool activated then was only interrupted.
  static bool is_handing_over() { return is_handing_over_; }

 protected:
  void onInitialize() override;
  bool eventFilter(QObject* watched, QEvent* event) override;

 private:
  void Toggle();
  void Show(bool is_paused);

  static bool is_handing_over_;
  QPointer<rviz::Tool> previous_;
  unsigned long released_at_ = 0;  ///< X's time of the last release of its key [ms].
  bool is_first_of_toolbar_ = false;
  ServiceCaller server_;
  ros::Subscriber state_;
  std::optional<bool> is_paused_;  // empty before the first state message
  QIcon pause_icon_;
  QIcon resume_icon_;
};

}  // namespace flatland_viz
