#include "pause_sim_tool.hpp"

#include <ros/node_handle.h>
#include <rviz/display_context.h>
#include <rviz/load_resource.h>
#include <rviz/render_panel.h>
#include <rviz/tool_manager.h>
#include <rviz/view_manager.h>
#include <std_srvs/Empty.h>

#include <QKeyEvent>
#include <QScopedValueRollback>
#include <pluginlib/class_list_macros.hpp>

namespace flatland_viz {

using flatland_msgs::SimulationState;

bool PauseSimTool::is_handing_over_ = false;

void PauseSimTool::onInitialize() {
  rviz::ToolManager* manager = context_->getToolManager();
  previous_ = manager->getCurrentTool();
  // rviz activates the first tool of a toolbar once it is initialized, without a user's action.
  is_first_of_toolbar_ = manager->getDefaultTool() == nullptr;
  connect(manager, &rviz::ToolManager::toolChanged, this, [this](rviz::Tool* current) {
    if (current != this) previous_ = current;
  });
  context_->getViewManager()->getRenderPanel()->installEventFilter(this);
  pause_icon_ = getIcon();
  resume_icon_ = rviz::loadPixmap("package://flatland_viz/icons/resume.svg");
  setName("Pause");
  ros::NodeHandle node;
  node.setCallbackQueue(context_->getUpdateQueue());
  state_ = node.subscribe<SimulationState>("/flatland_server/state", 1,
                                           [this](const SimulationState::ConstPtr& state) {
                                             if (is_paused_ != static_cast<bool>(state->paused))
                                               Show(state->paused);
                                           });
}

bool PauseSimTool::eventFilter(QObject* watched, QEvent* event) {
  if (event->type() == QEvent::KeyPress || event->type() == QEvent::KeyRelease) {
    const auto* key = static_cast<QKeyEvent*>(event);
    if (key->key() == Qt::Key_Space) {
      // X repeats a key by a release and a press of one time. Qt takes the press for a new one if
      // it was not received together with the release.
      const bool is_repeat = key->isAutoRepeat() || key->timestamp() == released_at_;
      if (event->type() == QEvent::KeyPress && is_repeat) return true;
      if (event->type() == QEvent::KeyRelease) released_at_ = key->timestamp();
    }
  }
  return rviz::Tool::eventFilter(watched, event);
}

void PauseSimTool::activate() {
  const bool is_by_user = !is_first_of_toolbar_;
  is_first_of_toolbar_ = false;
  if (is_by_user) Toggle();

  rviz::ToolManager* manager = context_->getToolManager();
  rviz::Tool* next = previous_ ? previous_.data() : manager->getDefaultTool();
  if (!next || next == this) return;
  const QScopedValueRollback<bool> handing_over(is_handing_over_, true);
  manager->setCurrentTool(next);
}

void PauseSimTool::Toggle() {
  if (server_.is_calling()) return;
  server_.Call<std_srvs::Empty>("/toggle_pause", {},
                                [this](const QString& error, const std_srvs::Empty::Response&) {
                                  if (!error.isEmpty()) setStatus(error.toHtmlEscaped());
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

}  // namespace flatland_viz

PLUGINLIB_EXPORT_CLASS(flatland_viz::PauseSimTool, rviz::Tool)
