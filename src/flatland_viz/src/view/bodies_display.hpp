#pragma once

/// An rviz display for the bodies of models.

#include <visualization_msgs/MarkerArray.h>

#include <map>
#include <memory>
#include <string>
#include <utility>

#include "topic_display.hpp"

namespace flatland_viz {

/// Shows lines and triangles of a MarkerArray. rviz's own display makes a marker anew at each
/// message; here a marker that only moves keeps its buffer. Bodies stay when simulated time goes
/// back: the server replaces all of them by one message.
class BodiesDisplay : public TopicDisplay {
 public:
  BodiesDisplay();
  ~BodiesDisplay() override;

  void update(float wall_dt, float ros_dt) override;

 protected:
  ros::Subscriber Subscribe(const std::string& topic) override;
  void Clear() override { bodies_.clear(); }

 private:
  struct Body;

  void Show(const visualization_msgs::MarkerArray::ConstPtr& message);

  std::string frame_;
  std::map<std::pair<std::string, int>, std::unique_ptr<Body>> bodies_;  // by namespace and number
};

}  // namespace flatland_viz
