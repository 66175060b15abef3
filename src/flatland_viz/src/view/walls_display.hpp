#pragma once

/// An rviz display for walls: millions of lines that hardly ever change.

#include <OgreMaterial.h>
#include <flatland_msgs/Walls.h>

#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "topic_display.hpp"

namespace flatland_viz {

class WallLines;

/// Shows the walls of all layers, from a topic with flatland_msgs/Walls.
///
/// A line is 5 cm wide, but at least a pixel, so that it is visible from afar. The outlines of a
/// map image are filled. Messages are received on rviz's second thread, and put into buffers in
/// portions: the view stays usable meanwhile.
///
/// Walls stay when simulated time goes back, as they do not depend on it.
class WallsDisplay : public TopicDisplay {
 public:
  WallsDisplay();
  ~WallsDisplay() override;

  void update(float wall_dt, float ros_dt) override;

 protected:
  ros::Subscriber Subscribe(const std::string& topic) override;
  void Clear() override;

 private:
  /// The walls of a layer that are shown.
  struct Layer;

  void Receive(const flatland_msgs::Walls::ConstPtr& message);
  void BeginShowing();
  void ShowMore();

  rviz::Property* progress_;  // percent of the walls that are shown
  rviz::Property* bounds_;    // of the walls [m]; null without walls
  std::mutex mutex_;
  /// A message, and for each of its layers the corners of triangles within its outlines, and the
  /// ends of those lines that are drawn; none: all.
  struct Filled {
    flatland_msgs::Walls::ConstPtr walls;
    std::vector<std::vector<float>> fills, lines;
  };
  std::optional<Filled> received_;  // guarded by mutex_
  std::optional<Filled> showing_;   // until all of it is in layers_
  std::size_t next_layer_ = 0;      // of showing_
  std::size_t next_number_ = 0;     // of that layer's lines
  std::string frame_;               // of the walls
  std::vector<std::unique_ptr<Layer>> layers_;
};

}  // namespace flatland_viz
