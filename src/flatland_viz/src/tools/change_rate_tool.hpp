#pragma once

/// rviz's button to change the simulation's rate.

#include <flatland_msgs/SimulationState.h>
#include <ros/subscriber.h>

#include <QPointer>
#include <optional>

#include "one_shot_tool.hpp"
#include "rate_dialog.hpp"
#include "service_caller.hpp"

namespace rviz {
class EditableEnumProperty;
}

namespace flatland_viz {

/// Opens a dialog. The property "Rate" follows the server, and changes the rate if it is edited.
class ChangeRateTool : public OneShotTool {
 public:
  ChangeRateTool();
  ~ChangeRateTool() override;

  /// The rate belongs to the simulation: opening a configuration does not change it.
  void load(const rviz::Config& /*config*/) override {}

 protected:
  void onInitialize() override;

 private:
  void Run() override;
  void Send(double rate);
  void Follow(const flatland_msgs::SimulationState& state);
  void OnPropertyEdited();
  void ShowPresentRate();
  void ShowError(const QString& error);

  rviz::EditableEnumProperty* rate_;  // belongs to the tool's property container
  bool is_following_ = false;         // the property is being set, not edited
  ServiceCaller server_;
  ros::Subscriber subscriber_;
  std::optional<flatland_msgs::SimulationState> state_;  // the last message; empty at first
  QPointer<RateDialog> dialog_;                          // belongs to the window, if there is one
};

}  // namespace flatland_viz
