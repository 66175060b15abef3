#pragma once

/// Subscribes to the simulation's state.

#include <flatland_msgs/SimulationState.h>
#include <ros/subscriber.h>

#include <functional>

namespace rviz {
class DisplayContext;
}

namespace flatland_viz {

/// Calls `callback` on the window's thread for each message, until the subscriber is destroyed.
ros::Subscriber SubscribeToState(
    rviz::DisplayContext& context,
    const std::function<void(const flatland_msgs::SimulationState& state)>& callback);

}  // namespace flatland_viz
