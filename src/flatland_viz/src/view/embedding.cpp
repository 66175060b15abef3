/// Parts of rviz and roscpp for a Python program that embeds rviz: its bindings lack them.

#include <OgreRenderSystem.h>
#include <OgreRenderSystemCapabilities.h>
#include <OgreRoot.h>
#include <ros/init.h>
#include <rviz/ogre_helpers/render_system.h>

#include <string>

/// Starts rviz's node as rviz does, but with remappings, "from:=to".
extern "C" void flatland_viz_start_roscpp(int count, const char* const* remappings) {
  ros::M_string names;
  for (int i = 0; i < count; ++i) {
    const std::string remapping = remappings[i];
    const std::size_t at = remapping.find(":=");
    names[remapping.substr(0, at)] = remapping.substr(at + 2);
  }
  ros::init(names, "rviz", ros::init_options::AnonymousName);
}

/// Unregisters all that rviz has subscribed to and published. rviz must not be used any more.
extern "C" void flatland_viz_shut_down_roscpp() { ros::shutdown(); }

/// Switches multisampling off for all windows of rviz to come if OpenGL runs on the processor,
/// where it makes a frame three times as expensive.
///
/// To be called once there is a QApplication, and before rviz's first window.
extern "C" void flatland_viz_limit_anti_aliasing() {
  Ogre::RenderSystem* system = rviz::RenderSystem::get()->root()->getRenderSystem();
  const std::string device = system->getCapabilities()->getDeviceName();
  for (const char* software : {"llvmpipe", "softpipe", "swrast"}) {
    if (device.find(software) != std::string::npos) rviz::RenderSystem::disableAntiAliasing();
  }
}
