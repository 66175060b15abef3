#pragma once

/// The models in the world, by the server's topics.

#include <flatland_msgs/ModelList.h>
#include <flatland_msgs/ModelStates.h>
#include <geometry_msgs/Pose2D.h>
#include <ros/subscriber.h>

#include <QColor>
#include <QObject>
#include <QPointF>
#include <QRectF>
#include <map>
#include <memory>
#include <string>

namespace rviz {
class DisplayContext;
}

namespace flatland_viz {

struct WorldModel {
  flatland_msgs::ModelInfo info;
  flatland_msgs::ModelState state;
  int color_index = 0;

  /// True if its state is known, from the first message on.
  bool is_placed() const { return !state.bodies.empty(); }
  /// The topic of its velocity commands; empty if it has no drive.
  std::string command_topic() const;
  /// True if it has a drive: it takes velocities. Boxes, doors and fixed sensors have none.
  bool is_robot() const;
  /// Its accent colour.
  QColor color() const;
  /// The distance from the middle of its bodies to the farthest corner of their boxes [m].
  double radius() const;
  /// That middle in the world while the model's origin is at a pose, with its heading.
  geometry_msgs::Pose2D MiddleAt(const geometry_msgs::Pose2D& pose) const;
  /// The same, with the origin where it was last [m].
  QPointF middle_in_world() const;
  /// True if a point of the world [m] is within one of its bodies.
  bool Contains(const QPointF& point) const;

 private:
  /// The box around its bodies, in its own frame.
  QRectF Extent() const;
};

/// Follows the models. All of it happens on the window's thread.
class WorldModels : public QObject {
  Q_OBJECT

 public:
  /// The models of a window. Displays and tools of one window share them.
  static std::shared_ptr<WorldModels> Of(rviz::DisplayContext& context);

  /// By name.
  const std::map<std::string, WorldModel>& models() const { return models_; }
  /// Null if there is no such model.
  const WorldModel* Find(const std::string& name) const;
  /// A model of this file and namespace, with topics: another one of them would have the same
  /// topics. Null if there is none.
  const WorldModel* FindTwin(const QString& file, const std::string& ns) const;
  /// The name, or if it is taken, the same with the next number that is free: box_2, r3 for r2.
  QString FreeName(const QString& name) const;
  /// Incremented by every change.
  unsigned revision() const { return revision_; }

  /// The model that is selected, and the one under the mouse; empty if none is.
  const std::string& selected() const { return selected_; }
  const std::string& hovered() const { return hovered_; }
  void Select(const std::string& name);  ///< also one that is yet to come
  void Hover(const std::string& name);
  /// The model that the mouse moves or turns; empty if there is none.
  const std::string& dragged() const { return dragged_; }
  void SetDragged(const std::string& name) { dragged_ = name; }

 Q_SIGNALS:
  void Selected();
  void Listed();
  void Moved(const flatland_msgs::ModelStates& states);

 private:
  explicit WorldModels(rviz::DisplayContext& context);
  void SetList(const flatland_msgs::ModelList& list);
  void SetStates(const flatland_msgs::ModelStates& states);

  std::map<std::string, WorldModel> models_;
  std::string selected_;
  std::string hovered_;
  std::string dragged_;
  unsigned revision_ = 0;
  ros::Subscriber list_;
  ros::Subscriber states_;
};

geometry_msgs::Pose2D MakePose(double x, double y, double theta = 0);

/// Composes poses: transforms `inner` out of the frame that `pose` describes.
geometry_msgs::Pose2D Compose(const geometry_msgs::Pose2D& pose,
                              const geometry_msgs::Pose2D& inner);

}  // namespace flatland_viz
