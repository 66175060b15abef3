/// The end of rviz's ROS node, for the window: Python cannot call roscpp.

#include <ros/init.h>

/// Unregisters all that rviz has subscribed to and published. rviz must not be used any more.
extern "C" void flatland_viz_shut_down_roscpp() { ros::shutdown(); }
