#include "pause_sim_tool.hpp"

#include <rviz/display_context.h>
#include <rviz/load_resource.h>
#include <rviz/tool_manager.h>
#include <std_srvs/Empty.h>

#include "state_subscriber.hpp"

namespace flatland_viz {

void PauseSimTool::onInitialize() {
  OneShotTool::onInitialize();
  pause_icon_ = getIcon();
  resume_icon_ = rviz::loadPixmap("package://flatland_viz/icons/resume.svg");
  setName("Pause");
  state_ = SubscribeToState(*context_, [this](const flatland_msgs::SimulationState& state) {
    if (is_paused_ != static_cast<bool>(state.paused)) Show(state.paused);
  });
}

void PauseSimTool::Show(bool is_paused) {
  const bool is_change = is_paused_.has_value();
  is_paused_ = is_paused;
  setName(is_paused ? "Resume" : "Pause");
  setIcon(is_paused ? resume_icon_ : pause_icon_);
  context_->getToolManager()->refreshTool(this);
  if (is_change) setStatus(is_paused ? "The simulation is paused." : "");
}

void PauseSimTool::Run() {
  if (server_.is_calling()) return;
  server_.Call<std_srvs::Empty>("/toggle_pause", {},
                                [this](const QString& error, const std_srvs::Empty::Response&) {
                                  if (!error.isEmpty()) setStatus(error.toHtmlEscaped());
                                });
}

}  // namespace flatland_viz
