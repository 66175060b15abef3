#include "bodies_display.hpp"

#include <rviz/properties/int_property.h>
#include <rviz/properties/ros_topic_property.h>

#include <pluginlib/class_list_macros.hpp>

namespace flatland_viz {

void BodiesDisplay::reset() {
  rviz::Display::reset();
  if (!isEnabled()) return;
  is_of_former_run_ = true;
  unsubscribe();
  subscribe();
}

void BodiesDisplay::onDisable() {
  rviz::MarkerDisplay::onDisable();
  is_of_former_run_ = false;
}

void BodiesDisplay::subscribe() {
  if (!isEnabled() || marker_topic_property_->getTopicStd().empty()) return;
  try {
    array_sub_ = update_nh_.subscribe(marker_topic_property_->getTopicStd(),
                                      static_cast<uint32_t>(queue_size_property_->getInt()),
                                      &BodiesDisplay::Receive, this);
    setStatus(rviz::StatusProperty::Ok, "Topic", "OK");
  } catch (const ros::Exception& error) {
    setStatus(rviz::StatusProperty::Error, "Topic", error.what());
  }
}

void BodiesDisplay::unsubscribe() { array_sub_.shutdown(); }

void BodiesDisplay::Receive(const visualization_msgs::MarkerArray::ConstPtr& markers) {
  if (is_of_former_run_) deleteAllMarkers();
  is_of_former_run_ = false;
  incomingMarkerArray(markers);
}

}  // namespace flatland_viz

PLUGINLIB_EXPORT_CLASS(flatland_viz::BodiesDisplay, rviz::Display)
