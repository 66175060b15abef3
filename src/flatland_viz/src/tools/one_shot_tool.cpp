#include "one_shot_tool.hpp"

#include <rviz/display_context.h>
#include <rviz/render_panel.h>
#include <rviz/tool_manager.h>
#include <rviz/view_manager.h>

#include <QKeyEvent>
#include <QScopedValueRollback>

namespace flatland_viz {

bool OneShotTool::is_handing_over_ = false;

void OneShotTool::onInitialize() {
  rviz::ToolManager* manager = context_->getToolManager();
  previous_ = manager->getCurrentTool();
  // rviz activates the first tool of a toolbar once it is initialized, without a user's action.
  is_first_of_toolbar_ = manager->getDefaultTool() == nullptr;
  connect(manager, &rviz::ToolManager::toolChanged, this, [this](rviz::Tool* current) {
    if (current != this) previous_ = current;
  });
  context_->getViewManager()->getRenderPanel()->installEventFilter(this);
}

bool OneShotTool::eventFilter(QObject* watched, QEvent* event) {
  if (event->type() == QEvent::KeyPress || event->type() == QEvent::KeyRelease) {
    const auto* key = static_cast<QKeyEvent*>(event);
    if (key->key() == QChar(shortcut_key_).toUpper().unicode()) {
      // X repeats a key by a release and a press of one time. Qt takes the press for a new one if
      // it was not received together with the release.
      const bool is_repeat = key->isAutoRepeat() || key->timestamp() == released_at_;
      if (event->type() == QEvent::KeyPress && is_repeat) return true;
      if (event->type() == QEvent::KeyRelease) released_at_ = key->timestamp();
    }
  }
  return rviz::Tool::eventFilter(watched, event);
}

void OneShotTool::activate() {
  const bool is_by_user = !is_first_of_toolbar_;
  is_first_of_toolbar_ = false;
  if (is_by_user) Run();

  rviz::ToolManager* manager = context_->getToolManager();
  rviz::Tool* next = previous_ ? previous_.data() : manager->getDefaultTool();
  if (!next || next == this) return;
  const QScopedValueRollback<bool> handing_over(is_handing_over_, true);
  manager->setCurrentTool(next);
}

}  // namespace flatland_viz
