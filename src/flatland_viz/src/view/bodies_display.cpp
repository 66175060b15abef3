/// An rviz display for the bodies of models.

#include <rviz/render_panel.h>
#include <rviz/view_manager.h>
#include <visualization_msgs/MarkerArray.h>

#include <map>
#include <memory>
#include <pluginlib/class_list_macros.hpp>
#include <string>
#include <utility>
#include <vector>

#include "topic_display.hpp"
#include "wall_lines.hpp"

namespace flatland_viz {

using visualization_msgs::Marker;

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

struct BodiesDisplay::Body : LineGroup {
  Body(const Marker& marker, Ogre::SceneNode& parent)
      : LineGroup(marker.color, parent), marker(marker) {
    std::vector<float> points;
    for (const geometry_msgs::Point& point : marker.points) {
      points.push_back(static_cast<float>(point.x));
      points.push_back(static_cast<float>(point.y));
    }
    const bool are_lines = marker.type == Marker::LINE_LIST;
    Add(points.data(), marker.points.size(),
        are_lines ? Ogre::RenderOperation::OT_LINE_LIST : Ogre::RenderOperation::OT_TRIANGLE_LIST);
  }

  bool LooksLike(const Marker& other) const {
    return marker.type == other.type && marker.color == other.color &&
           marker.points == other.points;
  }

  void Place(const geometry_msgs::Pose& pose) {
    const auto real = [](double number) { return static_cast<Ogre::Real>(number); };
    const auto &at = pose.position, &height = marker.points.front();
    const auto& turn = pose.orientation;
    node->setPosition(real(at.x), real(at.y), real(at.z + height.z));
    node->setOrientation(real(turn.w), real(turn.x), real(turn.y), real(turn.z));
  }

  Marker marker;  // as it was when the lines were made
};

BodiesDisplay::BodiesDisplay()
    : TopicDisplay(ros::message_traits::datatype<visualization_msgs::MarkerArray>(),
                   "A topic with the markers of all models.") {}

BodiesDisplay::~BodiesDisplay() { subscriber_.shutdown(); }

ros::Subscriber BodiesDisplay::Subscribe(const std::string& topic) {
  return update_nh_.subscribe(topic, 10, &BodiesDisplay::Show, this);
}

void BodiesDisplay::Show(const visualization_msgs::MarkerArray::ConstPtr& message) {
  decltype(bodies_) former;  // those of before a DELETEALL, which may come again
  for (const Marker& marker : message->markers) {
    if (marker.action == Marker::DELETEALL) former = std::exchange(bodies_, {});
    if (marker.action != Marker::ADD || marker.points.size() < 2) continue;
    const auto key = std::make_pair(marker.ns, marker.id);
    std::unique_ptr<Body>& body = bodies_[key];
    if (former.count(key) > 0) body = std::move(former[key]);
    if (!body || !body->LooksLike(marker)) body = std::make_unique<Body>(marker, *getSceneNode());
    body->Place(marker.pose);
    frame_ = marker.header.frame_id;
  }
}

void BodiesDisplay::update(float, float) {
  if (bodies_.empty()) return;
  Place(frame_);
  const rviz::RenderPanel& panel = *context_->getViewManager()->getRenderPanel();
  for (const auto& [key, body] : bodies_) {
    SetLineWidth(*body->material, LineWidth(panel, static_cast<float>(body->marker.scale.x)));
  }
}

}  // namespace flatland_viz

PLUGINLIB_EXPORT_CLASS(flatland_viz::BodiesDisplay, rviz::Display)
