#include "world_models.hpp"

#include <ros/node_handle.h>
#include <rviz/display_context.h>

#include <QDir>
#include <QFileInfo>
#include <QRegularExpression>
#include <QTransform>
#include <algorithm>
#include <array>
#include <cmath>

namespace flatland_viz {
namespace {

// The palette of Okabe and Ito, which is safe for colour-blind people, without the colours that are
// faint on the light or the dark background.
const std::array<QColor, 6> kColors = {QColor(213, 94, 0),  QColor(0, 114, 178),
                                       QColor(0, 158, 115), QColor(204, 121, 167),
                                       QColor(230, 159, 0), QColor(86, 180, 233)};

/// From the frame of a pose to that around it.
QTransform TransformOf(const geometry_msgs::Pose2D& pose) {
  return QTransform().translate(pose.x, pose.y).rotateRadians(pose.theta);
}

QRectF BoxOf(const flatland_msgs::BodyInfo& body) {
  return {QPointF(body.min_x, body.min_y), QPointF(body.max_x, body.max_y)};
}

}  // namespace

std::string WorldModel::command_topic() const {
  for (const flatland_msgs::PluginInfo& plugin : info.plugins) {
    for (const flatland_msgs::TopicInfo& topic : plugin.topics) {
      if (!topic.is_published && topic.type == "geometry_msgs/Twist") return topic.name;
    }
  }
  return {};
}

bool WorldModel::is_robot() const {
  return !command_topic().empty() ||
         std::any_of(info.plugins.begin(), info.plugins.end(), [](const auto& plugin) {
           return QString::fromStdString(plugin.type).endsWith("Drive");
         });
}

QColor WorldModel::color() const {
  return kColors[static_cast<std::size_t>(color_index) % kColors.size()];
}

QRectF WorldModel::Extent() const {
  QRectF box;
  const QTransform into_model = TransformOf(state.pose).inverted();
  for (std::size_t i = 0; i < std::min(state.bodies.size(), info.bodies.size()); ++i) {
    box |= (TransformOf(state.bodies[i]) * into_model).mapRect(BoxOf(info.bodies[i]));
  }
  return box;
}

geometry_msgs::Pose2D WorldModel::MiddleAt(const geometry_msgs::Pose2D& pose) const {
  const QPointF middle = Extent().center();
  return Compose(pose, MakePose(middle.x(), middle.y()));
}

QPointF WorldModel::middle_in_world() const {
  const geometry_msgs::Pose2D middle = MiddleAt(state.pose);
  return {middle.x, middle.y};
}

double WorldModel::radius() const {
  const QRectF box = Extent();
  return std::hypot(box.width(), box.height()) / 2;
}

bool WorldModel::Contains(const QPointF& point) const {
  for (std::size_t i = 0; i < std::min(state.bodies.size(), info.bodies.size()); ++i) {
    const QPointF in_body = TransformOf(state.bodies[i]).inverted().map(point);
    if (BoxOf(info.bodies[i]).contains(in_body)) return true;
  }
  return false;
}

std::shared_ptr<WorldModels> WorldModels::Of(rviz::DisplayContext& context) {
  static std::map<rviz::DisplayContext*, std::weak_ptr<WorldModels>> shared;
  std::shared_ptr<WorldModels> models = shared[&context].lock();
  if (!models) {
    models.reset(new WorldModels(context));
    shared[&context] = models;
  }
  return models;
}

WorldModels::WorldModels(rviz::DisplayContext& context) {
  ros::NodeHandle node;
  node.setCallbackQueue(context.getUpdateQueue());
  list_ = node.subscribe<flatland_msgs::ModelList>(
      "/flatland_server/models", 1,
      [this](const flatland_msgs::ModelList::ConstPtr& list) { SetList(*list); });
  states_ = node.subscribe<flatland_msgs::ModelStates>(
      "/flatland_server/model_states", 10,
      [this](const flatland_msgs::ModelStates::ConstPtr& states) { SetStates(*states); },
      ros::VoidConstPtr(), ros::TransportHints().tcpNoDelay());
}

const WorldModel* WorldModels::Find(const std::string& name) const {
  const auto found = models_.find(name);
  return found == models_.end() ? nullptr : &found->second;
}

const WorldModel* WorldModels::FindTwin(const QString& file, const std::string& ns) const {
  // The server looks up a relative name beside its world, and in its own folders.
  const bool is_relative = QFileInfo(file).isRelative();
  const QString path =
      is_relative ? QDir::cleanPath("/" + file) : QFileInfo(file).canonicalFilePath();
  if (path.isEmpty()) return nullptr;  // there is no such file on this machine
  for (const auto& [name, model] : models_) {
    const QString known = QString::fromStdString(model.info.yaml_path);
    const bool is_same = is_relative ? known.endsWith(path) : known == path;
    const auto& plugins = model.info.plugins;
    const bool has_topics = std::any_of(plugins.begin(), plugins.end(),
                                        [](const auto& each) { return !each.topics.empty(); });
    if (is_same && has_topics && model.info.ns == ns) return &model;
  }
  return nullptr;
}

QString WorldModels::FreeName(const QString& name) const {
  const auto match = QRegularExpression("^(.*?)([0-9]{1,6})$").match(name);
  const QString stem = match.hasMatch() ? match.captured(1) : name + "_";
  int number = match.hasMatch() ? match.captured(2).toInt() : 1;
  QString free_name = name;
  while (Find(free_name.toStdString())) free_name = stem + QString::number(++number);
  return free_name;
}

void WorldModels::Select(const std::string& name) {
  if (name == selected_) return;
  selected_ = name;
  ++revision_;
  Q_EMIT Selected();
}

void WorldModels::Hover(const std::string& name) {
  if (name == hovered_) return;
  hovered_ = name;
  ++revision_;
}

void WorldModels::SetList(const flatland_msgs::ModelList& list) {
  std::map<std::string, WorldModel> models;
  std::array<int, kColors.size()> uses{};
  for (const flatland_msgs::ModelInfo& info : list.models) {
    const WorldModel* before = Find(info.name);
    if (before && before->is_robot()) ++uses[static_cast<std::size_t>(before->color_index)];
  }
  for (const flatland_msgs::ModelInfo& info : list.models) {
    WorldModel& model = models[info.name];
    model.info = info;
    const WorldModel* before = Find(info.name);
    if (before && before->state.bodies.size() == info.bodies.size()) model.state = before->state;
    if (before && before->is_robot()) {
      model.color_index = before->color_index;
    } else if (model.is_robot()) {  // the colour that the fewest have
      const auto least = std::min_element(uses.begin(), uses.end());
      model.color_index = static_cast<int>(least - uses.begin());
      ++*least;
    }
  }
  const bool knew_selected = Find(selected_) != nullptr;  // otherwise it may be yet to come
  models_ = std::move(models);
  if (!Find(hovered_)) hovered_.clear();
  if (knew_selected && !Find(selected_)) Select("");
  ++revision_;
  Q_EMIT Listed();
}

void WorldModels::SetStates(const flatland_msgs::ModelStates& states) {
  for (const flatland_msgs::ModelState& state : states.models) {
    const auto found = models_.find(state.name);
    if (found == models_.end()) continue;  // it is of a newer list, or of an older one
    if (found->second.info.bodies.size() == state.bodies.size()) found->second.state = state;
  }
  if (!states.models.empty()) ++revision_;
  Q_EMIT Moved(states);
}

geometry_msgs::Pose2D MakePose(double x, double y, double theta) {
  geometry_msgs::Pose2D pose;
  pose.x = x;
  pose.y = y;
  pose.theta = theta;
  return pose;
}

geometry_msgs::Pose2D Compose(const geometry_msgs::Pose2D& pose,
                              const geometry_msgs::Pose2D& inner) {
  const double c = std::cos(pose.theta), s = std::sin(pose.theta);
  return MakePose(pose.x + c * inner.x - s * inner.y, pose.y + s * inner.x + c * inner.y,
                  pose.theta + inner.theta);
}

}  // namespace flatland_viz
