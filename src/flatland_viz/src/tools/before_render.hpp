#pragma once

/// Places what depends on the camera, when the camera of a frame is known.

#include <OgreSceneManager.h>

#include <functional>

namespace Ogre {
class Viewport;
}

namespace rviz {
class DisplayContext;
}

namespace flatland_viz {

/// Calls a function before each frame of rviz's main view. Displays and tools are updated before the
/// view is, so that what they place by its scale would be late by a frame.
class BeforeRender : public Ogre::SceneManager::Listener {
 public:
  using Place = std::function<void(const Ogre::Viewport& viewport, double pixel_ratio)>;

  BeforeRender(rviz::DisplayContext& context, Place place);
  ~BeforeRender() override;
  BeforeRender(const BeforeRender&) = delete;
  BeforeRender& operator=(const BeforeRender&) = delete;

 private:
  void preUpdateSceneGraph(Ogre::SceneManager* scene, Ogre::Camera* camera) override;
  void sceneManagerDestroyed(Ogre::SceneManager* scene) override;

  rviz::DisplayContext& context_;
  Place place_;
  Ogre::SceneManager* scene_;
};

}  // namespace flatland_viz
