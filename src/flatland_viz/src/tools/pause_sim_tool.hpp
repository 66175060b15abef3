#pragma once

/// rviz's button that stops the simulation and lets it go on.

#include <flatland_msgs/SimulationState.h>
#include <ros/subscriber.h>

#include <QIcon>
#include <optional>

#include "one_shot_tool.hpp"
#include "service_caller.hpp"

namespace flatland_viz {

/// Name and icon say what a click does: "Pause" or "Resume".
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
  std::optional<bool> is_paused_;  // nothing while no server has told
  QIcon pause_icon_;
  QIcon resume_icon_;
};

}  // namespace flatland_viz
