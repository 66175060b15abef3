/// The start and the end of rviz's ROS node, for the window: Python cannot call roscpp.

#include <ros/init.h>

#include <string>

/// Starts the node as rviz does, but with remappings, "from:=to".
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
