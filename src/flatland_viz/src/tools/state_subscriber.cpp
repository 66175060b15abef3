#include "state_subscriber.hpp"

#include <ros/node_handle.h>
#include <rviz/display_context.h>

namespace flatland_viz {

ros::Subscriber SubscribeToState(
    rviz::DisplayContext& context,
    const std::function<void(const flatland_msgs::SimulationState& state)>& callback) {
  ros::NodeHandle node;
  node.setCallbackQueue(context.getUpdateQueue());
  return node.subscribe<flatland_msgs::SimulationState>(
      "/flatland_server/state", 1,
      [callback](const flatland_msgs::SimulationState::ConstPtr& state) { callback(*state); });
}

}  // namespace flatland_viz
