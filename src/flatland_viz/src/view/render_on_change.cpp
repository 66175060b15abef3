/// An rviz display without a picture of its own: with it, rviz draws its view only when that
/// changes.

#include <OgreFrameListener.h>
#include <OgreRenderWindow.h>
#include <OgreRoot.h>
#include <rviz/display.h>
#include <rviz/display_context.h>
#include <rviz/render_panel.h>
#include <rviz/view_manager.h>
#include <time.h>

#include <QEvent>
#include <QPointer>
#include <QWindow>
#include <algorithm>
#include <cstdint>
#include <pluginlib/class_list_macros.hpp>

#include "scene_digest.hpp"

namespace flatland_viz {
namespace {

constexpr double kShare = 0.45;      // greatest share of a core for drawing
constexpr double kRest = 1.0;        // s: period of drawing even without a noticed change
constexpr double kActionTime = 0.5;  // s: time of unlimited drawing after an action of the user
constexpr double kMemory = 0.8;      // weight of earlier frames in the smoothed cost

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

/// Keeps rviz from drawing the main view at each of its updates, 30 times a second.
///
/// rviz goes on updating its displays at its frame rate. Before Ogre draws, this
/// compares a digest of the scene with the former one: a hidden scene is not drawn, and an
/// unchanged one once a second, since X may have lost the picture.
///
/// A frame may take long where a program draws instead of a graphics card. Frames are then further
/// apart, so that drawing takes half of a processor core at most; except while the user moves the
/// mouse in the view or types in it.
class RenderOnChange : public rviz::Display, private Ogre::FrameListener {
 public:
  ~RenderOnChange() override;

  /// Notices the user's actions in the view.
  bool eventFilter(QObject* watched, QEvent* event) override;

 protected:
  void onInitialize() override;
  void onEnable() override;
  void onDisable() override;
  void reset() override;

 private:
  bool frameStarted(const Ogre::FrameEvent& event) override;
  bool frameEnded(const Ogre::FrameEvent& event) override;

  bool IsDue(double now) const;

  QPointer<rviz::RenderPanel> panel_;
  Ogre::RenderWindow* window_ = nullptr;
  std::uint64_t digest_ = 0;
  bool is_requested_ = true;  // the scene has changed, or the drawn picture is lost
  bool is_drawing_ = false;
  double drawing_began_ = -1e9;  // s, steady clock: of the last frame
  double user_acted_ = -1e9;     // s, steady clock: a move of the mouse in the view, or a key
  double cpu_began_ = 0.0;       // s, processor time of the process
  double cost_ = 0.0;            // s, processor time of a frame, smoothed
};

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
  is_requested_ = true;
}

void RenderOnChange::onDisable() {
  Ogre::Root::getSingleton().removeFrameListener(this);
  if (!panel_) return;  // rviz is ending
  panel_->removeEventFilter(this);
  window_->setAutoUpdated(true);
}

void RenderOnChange::reset() {
  Display::reset();
  is_requested_ = true;
}

bool RenderOnChange::eventFilter(QObject* watched, QEvent* event) {
  switch (event->type()) {
    case QEvent::MouseMove:
    case QEvent::MouseButtonPress:
    case QEvent::MouseButtonRelease:
    case QEvent::Wheel:
    case QEvent::KeyPress:
    case QEvent::Resize:
      user_acted_ = Seconds(CLOCK_MONOTONIC);
      break;
    case QEvent::Show:
    case QEvent::Paint:
      is_requested_ = true;
      break;
    default:
      break;
  }
  return Display::eventFilter(watched, event);
}

bool RenderOnChange::IsDue(double now) const {
  const double age = now - drawing_began_, shortest = cost_ / kShare;
  if (!is_requested_) return age >= std::max(kRest, shortest);
  return age >= shortest || now - user_acted_ < kActionTime;
}

bool RenderOnChange::frameStarted(const Ogre::FrameEvent&) {
  if (!panel_) return true;
  const std::uint64_t digest = IsHidden(*panel_) ? digest_ : DigestOfScene(*window_);
  const double now = Seconds(CLOCK_MONOTONIC);
  is_requested_ |= digest != digest_ || IsHidden(*panel_);
  is_drawing_ = !IsHidden(*panel_) && IsDue(now);
  digest_ = digest;
  if (is_drawing_) {
    is_requested_ = false;
    drawing_began_ = now;
    cpu_began_ = Seconds(CLOCK_PROCESS_CPUTIME_ID);
  }
  window_->setAutoUpdated(is_drawing_);
  return true;
}

bool RenderOnChange::frameEnded(const Ogre::FrameEvent&) {
  if (is_drawing_) {
    const double cost = Seconds(CLOCK_PROCESS_CPUTIME_ID) - cpu_began_;
    cost_ = kMemory * cost_ + (1.0 - kMemory) * cost;
  }
  is_drawing_ = false;
  return true;
}

}  // namespace flatland_viz

PLUGINLIB_EXPORT_CLASS(flatland_viz::RenderOnChange, rviz::Display)
