#pragma once

/// Places objects that depend on the camera, once the camera of a frame is known.

#include <OgreFrameListener.h>

#include <functional>

namespace rviz {
class DisplayContext;
}

namespace flatland_viz {

/// Calls a function before each frame of rviz's main view. Displays and tools are updated before
/// the view is, so that objects placed by its scale would be late by a frame.
class BeforeRender : public Ogre::FrameListener {
 public:
  using Place = std::function<void(const Ogre::Viewport& viewport, double pixel_ratio)>;

  BeforeRender(rviz::DisplayContext& context, Place place);
  ~BeforeRender() override;
  BeforeRender(const BeforeRender&) = delete;
  BeforeRender& operator=(const BeforeRender&) = delete;

 private:
  bool frameStarted(const Ogre::FrameEvent& event) override;

  rviz::DisplayContext& context_;
  Place place_;
};

}  // namespace flatland_viz
