#pragma once

/// An rviz display without a picture of its own: with it, rviz draws its view only when that
/// changes.

#include <OgreFrameListener.h>
#include <rviz/display.h>

#include <QPointer>
#include <cstdint>

namespace rviz {
class RenderPanel;
}

namespace flatland_viz {

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

}  // namespace flatland_viz
