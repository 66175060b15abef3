#include "before_render.hpp"

#include <OgreViewport.h>
#include <rviz/display_context.h>
#include <rviz/render_panel.h>
#include <rviz/view_manager.h>

namespace flatland_viz {

BeforeRender::BeforeRender(rviz::DisplayContext& context, Place place)
    : context_(context), place_(std::move(place)), scene_(context.getSceneManager()) {
  scene_->addListener(this);
}

BeforeRender::~BeforeRender() {
  if (scene_) scene_->removeListener(this);
}

void BeforeRender::preUpdateSceneGraph(Ogre::SceneManager* /*scene*/, Ogre::Camera* camera) {
  const rviz::RenderPanel* panel = context_.getViewManager()->getRenderPanel();
  const Ogre::Viewport* viewport = panel ? panel->getViewport() : nullptr;
  if (viewport && viewport->getCamera() == camera) place_(*viewport, panel->devicePixelRatioF());
}

void BeforeRender::sceneManagerDestroyed(Ogre::SceneManager* /*scene*/) { scene_ = nullptr; }

}  // namespace flatland_viz
