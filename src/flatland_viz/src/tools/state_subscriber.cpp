#include "state_subscriber.hpp"

#include <ros/node_handle.h>
#include <rviz/display_context.h>

namespace flatland_viz {

ros::Subscriber ListenToState(
    rviz::DisplayContext& context,
    const std::function<void(const flatland_msgs::SimulationState& state)>& listener) {
  ros::NodeHandle node;
  node.setCallbackQueue(context.getUpdateQueue());
  return node.subscribe<flatland_msgs::SimulationState>(
      "/flatland_server/state", 1,
      [listener](const flatland_msgs::SimulationState::ConstPtr& state) { listener(*state); });
}

}  // namespace flatland_viz
