#include "ground_truth_frames.hpp"

#include <geometry_msgs/TransformStamped.h>
#include <ros/node_handle.h>
#include <tf2/exceptions.h>
#include <tf2/utils.h>
#include <tf2_ros/buffer.h>

#include <algorithm>
#include <cmath>

#include "world_models.hpp"
#include "world_plane.hpp"

namespace flatland_viz {
namespace {

const ros::Duration kHistory(2.0);  // of simulated time; transforms are not older
constexpr int kMaxDepth = 100;      // of transforms; a longer chain is a loop

geometry_msgs::Pose2D Between(const geometry_msgs::Pose2D& a, const geometry_msgs::Pose2D& b,
                              double part) {
  return MakePose(a.x + part * (b.x - a.x), a.y + part * (b.y - a.y),
                  a.theta + part * std::remainder(b.theta - a.theta, 2 * M_PI));
}

geometry_msgs::Pose2D Inverse(const geometry_msgs::Pose2D& pose) {
  const double c = std::cos(pose.theta), s = std::sin(pose.theta);
  return MakePose(-c * pose.x - s * pose.y, s * pose.x - c * pose.y, -pose.theta);
}

geometry_msgs::Pose2D Flat(const geometry_msgs::Transform& transform) {
  return MakePose(transform.translation.x, transform.translation.y,
                  tf2::getYaw(transform.rotation));
}

}  // namespace

GroundTruthFrames::GroundTruthFrames(std::shared_ptr<tf2_ros::Buffer> buffer,
                                     const WorldModels& models, ros::NodeHandle& node)
    : buffer_(std::move(buffer)), models_(models) {
  const auto note = [&node](const std::string& topic, std::set<std::string>& frames) {
    return node.subscribe<tf2_msgs::TFMessage>(
        topic, 1000, [&frames](const tf2_msgs::TFMessage::ConstPtr& message) {
          for (const auto& transform : message->transforms) {
            const std::string& frame = transform.child_frame_id;
            frames.insert(!frame.empty() && frame[0] == '/' ? frame.substr(1) : frame);
          }
        });
  };
  tf_ = note("/tf", published_);
  static_tf_ = note("/tf_static", static_published_);
}

void GroundTruthFrames::Clear() {
  motions_.clear();
  latest_ = ros::Time();
  placed_at_.clear();
  published_.clear();  // static transforms stay: each comes only once
}

void GroundTruthFrames::Add(const flatland_msgs::ModelStates& states) {
  if (states.stamp < latest_) Clear();
  for (const flatland_msgs::ModelState& state : states.models) {
    std::deque<Motion>& motion = motions_[state.name];
    // A model without messages has rested until the last one.
    if (!motion.empty() && motion.back().stamp < latest_) {
      motion.push_back({latest_, motion.back().state});
    }
    motion.push_back({states.stamp, state});
    while (motion.size() > 2 && motion[1].stamp + kHistory < states.stamp) motion.pop_front();
  }
  latest_ = states.stamp;
}

std::optional<std::string> GroundTruthFrames::FindRoot(const std::string& frame) const {
  std::string root = frame;
  for (int depth = 0; depth < kMaxDepth; ++depth) {
    std::string parent;
    if (root == WorldPlane::kFrame) return std::nullopt;
    const bool is_ours =
        roots_.count(root) > 0 && !published_.count(root) && !static_published_.count(root);
    if (is_ours || !buffer_->_getParent(root, ros::Time(), parent)) return root;
    root = parent;
  }
  return std::nullopt;
}

std::optional<geometry_msgs::Pose2D> GroundTruthFrames::TruePose(const std::string& model,
                                                                 std::size_t body,
                                                                 const ros::Time& time) const {
  const auto found = motions_.find(model);
  if (found == motions_.end()) return std::nullopt;
  const std::deque<Motion>& motion = found->second;
  const auto later =
      std::find_if(motion.begin(), motion.end(), [&](const Motion& m) { return m.stamp > time; });
  if (later == motion.begin()) return std::nullopt;
  const Motion& earlier = *(later - 1);
  if (body >= earlier.state.bodies.size()) return std::nullopt;
  if (later == motion.end() || body >= later->state.bodies.size()) {
    return earlier.state.bodies[body];
  }
  const double part = (time - earlier.stamp).toSec() / (later->stamp - earlier.stamp).toSec();
  return Between(earlier.state.bodies[body], later->state.bodies[body], part);
}

void GroundTruthFrames::Update() {
  std::set<std::string> roots;
  for (const auto& [name, model] : models_.models()) {
    for (std::size_t body = 0; body < model.info.bodies.size(); ++body) {
      const std::string& frame = model.info.bodies[body].frame_id;
      if (!buffer_->_frameExists(frame)) continue;  // nothing depends on it
      const auto root = FindRoot(frame);
      if (!root) continue;
      if (!roots.insert(*root).second) continue;
      Place(*root, name, body, frame);
    }
  }
  roots_ = std::move(roots);
}

void GroundTruthFrames::Place(const std::string& root, const std::string& model, std::size_t body,
                              const std::string& frame) {
  ros::Time time = latest_;
  geometry_msgs::Pose2D in_root;
  if (root != frame) {
    try {
      time = std::min(time, buffer_->lookupTransform(root, frame, ros::Time()).header.stamp);
      in_root = Flat(buffer_->lookupTransform(root, frame, time).transform);
    } catch (const tf2::TransformException&) {
      return;  // not at that time
    }
  }
  ros::Time& placed_at = placed_at_[root];
  const auto truth = TruePose(model, body, time);
  if (!truth || time <= placed_at) return;
  placed_at = time;

  const geometry_msgs::Pose2D pose = Compose(*truth, Inverse(in_root));
  geometry_msgs::TransformStamped transform;
  transform.header.stamp = time;
  transform.header.frame_id = WorldPlane::kFrame;
  transform.child_frame_id = root;
  transform.transform.translation.x = pose.x;
  transform.transform.translation.y = pose.y;
  transform.transform.rotation.z = std::sin(pose.theta / 2);
  transform.transform.rotation.w = std::cos(pose.theta / 2);
  buffer_->setTransform(transform, "ground truth");
}

}  // namespace flatland_viz
