#pragma once

/// rviz's button that pauses and resumes the simulation.

#include <flatland_msgs/SimulationState.h>
#include <ros/subscriber.h>

#include <QIcon>
#include <optional>

#include "one_shot_tool.hpp"
#include "service_caller.hpp"

namespace flatland_viz {

/// Its name and icon show what a click does: "Pause" or "Resume".
class PauseSimTool : public OneShotTool {
 public:
  PauseSimTool() { shortcut_key_ = ' '; }

 protected:
  void onInitialize() override;

 private:
  void Run() override;
  void Show(bool is_paused);

  ServiceCaller server_;
  ros::Subscriber state_;
  std::optional<bool> is_paused_;  // empty before the first state message
  QIcon pause_icon_;
  QIcon resume_icon_;
};

}  // namespace flatland_viz
