/// rviz's anti-aliasing, for a Python program that embeds rviz.

#include <OgreRenderSystem.h>
#include <OgreRenderSystemCapabilities.h>
#include <OgreRoot.h>
#include <rviz/ogre_helpers/render_system.h>

#include <string>

/// Switches multisampling off for all windows of rviz to come if OpenGL runs on the processor,
/// where it makes a frame three times as expensive.
///
/// To be called once there is a QApplication, and before rviz's first window.
///
/// @return whether it is off
extern "C" bool flatland_viz_limit_anti_aliasing() {
  Ogre::RenderSystem* system = rviz::RenderSystem::get()->root()->getRenderSystem();
  const std::string device = system->getCapabilities()->getDeviceName();
  const bool is_software = device.find("llvmpipe") != std::string::npos ||
                           device.find("softpipe") != std::string::npos ||
                           device.find("swrast") != std::string::npos;
  if (is_software) rviz::RenderSystem::disableAntiAliasing();
  return is_software;
}
