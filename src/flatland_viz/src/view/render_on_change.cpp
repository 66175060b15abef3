#include "render_on_change.hpp"

#include <OgreRenderWindow.h>
#include <OgreRoot.h>
#include <rviz/display_context.h>
#include <rviz/render_panel.h>
#include <rviz/view_manager.h>
#include <time.h>

#include <QEvent>
#include <QWindow>
#include <pluginlib/class_list_macros.hpp>

#include "exposures.hpp"
#include "scene_digest.hpp"

namespace flatland_viz {
namespace {

double Seconds(clockid_t clock) {
  timespec time;
  clock_gettime(clock, &time);
  return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
}

/// True if the window is minimised, on another desktop, or not shown yet.
bool IsHidden(const QWidget& widget) {
  const QWidget* top = widget.window();
  const QWindow* window = top->windowHandle();
  return !widget.isVisible() || top->isMinimized() || (window && !window->isExposed());
}

}  // namespace

RenderOnChange::RenderOnChange() = default;

RenderOnChange::~RenderOnChange() {
  if (initialized()) RenderOnChange::onDisable();
}

void RenderOnChange::onInitialize() {
  panel_ = context_->getViewManager()->getRenderPanel();
  window_ = panel_->getRenderWindow();
}

void RenderOnChange::onEnable() {
  Ogre::Root::getSingleton().addFrameListener(this);
  panel_->installEventFilter(this);
  unsigned long id = 0;
  window_->getCustomAttribute("WINDOW", &id);
  exposures_ = std::make_unique<Exposures>(id, [this] { schedule_.Request(); });
  schedule_.Request();
}

void RenderOnChange::onDisable() {
  Ogre::Root::getSingleton().removeFrameListener(this);
  exposures_.reset();
  if (!panel_) return;  // rviz is ending
  panel_->removeEventFilter(this);
  window_->setAutoUpdated(true);
}

void RenderOnChange::reset() {
  Display::reset();
  schedule_.Request();
}

bool RenderOnChange::eventFilter(QObject* watched, QEvent* event) {
  switch (event->type()) {
    case QEvent::MouseMove:
    case QEvent::MouseButtonPress:
    case QEvent::MouseButtonRelease:
    case QEvent::Wheel:
    case QEvent::KeyPress:
    case QEvent::Resize:
      schedule_.UserActed(Seconds(CLOCK_MONOTONIC));
      break;
    case QEvent::Show:
    case QEvent::Paint:
      schedule_.Request();
      break;
    default:
      break;
  }
  return Display::eventFilter(watched, event);
}

bool RenderOnChange::frameStarted(const Ogre::FrameEvent&) {
  if (!panel_) return true;
  is_drawing_ = false;
  if (IsHidden(*panel_)) {
    schedule_.Request();
  } else {
    const std::uint64_t digest = DigestOfScene(*window_);
    if (digest != digest_) schedule_.Request();
    digest_ = digest;
    drawing_began_ = Seconds(CLOCK_MONOTONIC);
    is_drawing_ = schedule_.IsDue(drawing_began_);
    cpu_began_ = Seconds(CLOCK_PROCESS_CPUTIME_ID);
  }
  window_->setAutoUpdated(is_drawing_);
  return true;
}

bool RenderOnChange::frameEnded(const Ogre::FrameEvent&) {
  if (is_drawing_) {
    schedule_.Drawn(drawing_began_, Seconds(CLOCK_PROCESS_CPUTIME_ID) - cpu_began_);
    is_drawing_ = false;
  }
  return true;
}

}  // namespace flatland_viz

PLUGINLIB_EXPORT_CLASS(flatland_viz::RenderOnChange, rviz::Display)
