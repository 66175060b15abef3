#include "before_render.hpp"

#include <OgreRoot.h>
#include <OgreViewport.h>
#include <rviz/display_context.h>
#include <rviz/render_panel.h>
#include <rviz/view_manager.h>

namespace flatland_viz {

BeforeRender::BeforeRender(rviz::DisplayContext& context, Place place)
    : context_(context), place_(std::move(place)) {
  Ogre::Root::getSingleton().addFrameListener(this);
}

BeforeRender::~BeforeRender() { Ogre::Root::getSingleton().removeFrameListener(this); }

bool BeforeRender::frameStarted(const Ogre::FrameEvent& /*event*/) {
  const rviz::RenderPanel* panel = context_.getViewManager()->getRenderPanel();
  const Ogre::Viewport* viewport = panel ? panel->getViewport() : nullptr;
  if (viewport && viewport->getCamera()) place_(*viewport, panel->devicePixelRatioF());
  return true;
}

}  // namespace flatland_viz
