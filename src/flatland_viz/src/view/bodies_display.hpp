#pragma once

/// An rviz display for the bodies of models.

#include <ros/subscriber.h>
#include <rviz/display.h>
#include <visualization_msgs/MarkerArray.h>

#include <map>
#include <memory>
#include <string>
#include <utility>

namespace rviz {
class RosTopicProperty;
}  // namespace rviz

namespace flatland_viz {

/// Shows lines and triangles of a MarkerArray. rviz's own display makes a marker anew at each
/// message; here a marker that only moves keeps its buffer. Bodies stay when simulated time goes
/// back: the server replaces all of them by one message.
class BodiesDisplay : public rviz::Display {
  Q_OBJECT

 public:
  BodiesDisplay();
  ~BodiesDisplay() override;

  void update(float wall_dt, float ros_dt) override;

 protected:
  void onEnable() override;
  void onDisable() override;

 private Q_SLOTS:
  void Resubscribe();

 private:
  struct Body;

  void Show(const visualization_msgs::MarkerArray::ConstPtr& message);

  rviz::RosTopicProperty* topic_;
  ros::Subscriber subscriber_;
  std::string frame_;
  std::map<std::pair<std::string, int>, std::unique_ptr<Body>> bodies_;  // by namespace and number
};

}  // namespace flatland_viz
