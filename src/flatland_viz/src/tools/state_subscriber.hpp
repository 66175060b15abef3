#pragma once

/// Listens to what the server tells about the simulation's progress.

#include <flatland_msgs/SimulationState.h>
#include <ros/subscriber.h>

#include <functional>

namespace rviz {
class DisplayContext;
}

namespace flatland_viz {

/// Calls `listener` on the window's thread for each message, until the subscriber is destroyed.
ros::Subscriber ListenToState(
    rviz::DisplayContext& context,
    const std::function<void(const flatland_msgs::SimulationState& state)>& listener);

}  // namespace flatland_viz
