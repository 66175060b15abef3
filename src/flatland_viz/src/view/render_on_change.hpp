#pragma once

/// An rviz display without a picture of its own: with it, rviz draws its view only when that
/// changes.

#include <OgreFrameListener.h>
#include <rviz/display.h>

#include <QPointer>
#include <cstdint>
#include <memory>

#include "draw_schedule.hpp"

namespace Ogre {
class RenderWindow;
}

namespace rviz {
class RenderPanel;
}

namespace flatland_viz {

class Exposures;

/// Keeps rviz from drawing the main view at each of its updates, 30 times a second.
///
/// rviz goes on updating its displays at its frame rate. Before Ogre draws, this
/// compares a digest of the scene with the former one: an unchanged or hidden scene is not drawn.
class RenderOnChange : public rviz::Display, private Ogre::FrameListener {
 public:
  RenderOnChange();
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

  QPointer<rviz::RenderPanel> panel_;
  Ogre::RenderWindow* window_ = nullptr;
  std::unique_ptr<Exposures> exposures_;
  DrawSchedule schedule_;
  std::uint64_t digest_ = 0;
  bool is_drawing_ = false;
  double drawing_began_ = 0.0;  // s, steady clock
  double cpu_began_ = 0.0;      // s, processor time of the process
};

}  // namespace flatland_viz
