#pragma once

/// Places robots without a localiser by their ground truth.

#include <flatland_msgs/ModelStates.h>
#include <ros/subscriber.h>
#include <tf2_msgs/TFMessage.h>

#include <deque>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>

namespace tf2_ros {
class Buffer;
}

namespace flatland_viz {

class WorldModels;

/// A robot publishes transforms from its odometry frame to its bodies and sensors. The
/// transform from the map to that odometry frame comes from a localiser; without it, scans could
/// not be shown.
///
/// This finds the root of the transforms of each body, such as "odom". If the root is not connected
/// to the map, its pose in the map is computed from the body's true pose in the map, and the body's
/// pose in the root. The transform map -> root goes to the transforms of this window alone. It ends
/// as soon as a node publishes that transform.
class GroundTruthFrames {
 public:
  GroundTruthFrames(std::shared_ptr<tf2_ros::Buffer> buffer, const WorldModels& models,
                    ros::NodeHandle& node);

  void Add(const flatland_msgs::ModelStates& states);
  /// Discards all poses and transforms: simulated time has begun again.
  void Clear();
  /// Computes the transforms at the present time; to be called often.
  void Update();
  /// The roots that are placed now, such as "odom".
  const std::set<std::string>& roots() const { return roots_; }

 private:
  struct Motion {
    ros::Time stamp;
    flatland_msgs::ModelState state;
  };

  /// The root of a frame's transforms; nothing if the frame is connected to the map.
  std::optional<std::string> FindRoot(const std::string& frame) const;
  std::optional<geometry_msgs::Pose2D> TruePose(const std::string& model, std::size_t body,
                                                const ros::Time& time) const;
  void Place(const std::string& root, const std::string& model, std::size_t body,
             const std::string& frame);

  std::shared_ptr<tf2_ros::Buffer> buffer_;
  const WorldModels& models_;
  ros::Subscriber tf_, static_tf_;
  std::map<std::string, std::deque<Motion>> motions_;  // by model, the oldest first
  ros::Time latest_;                                   // the last stamp of states
  std::set<std::string> roots_;
  std::set<std::string> published_, static_published_;  // frames to which nodes publish transforms
  std::map<std::string, ros::Time> placed_at_;          // the last stamp of each root
};

}  // namespace flatland_viz
