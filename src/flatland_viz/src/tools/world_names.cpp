#include "world_names.hpp"

#include <QDir>
#include <QFileInfo>
#include <QRegularExpression>
#include <algorithm>

namespace flatland_viz {
namespace {

bool HasTopics(const flatland_msgs::ModelInfo& model) {
  return std::any_of(
      model.plugins.begin(), model.plugins.end(),
      [](const flatland_msgs::PluginInfo& plugin) { return !plugin.topics.empty(); });
}

}  // namespace

bool WorldNames::IsTaken(const QString& name) const {
  return std::any_of(
      models_.models.begin(), models_.models.end(),
      [&](const flatland_msgs::ModelInfo& model) { return model.name == name.toStdString(); });
}

QString WorldNames::FreeName(const QString& name) const {
  if (!IsTaken(name)) return name;
  const auto match = QRegularExpression("^(.*?)([0-9]{1,6})$").match(name);
  const QString stem = match.hasMatch() ? match.captured(1) : name + "_";
  int number = match.hasMatch() ? match.captured(2).toInt() : 1;
  QString free_name;
  do {
    free_name = stem + QString::number(++number);
  } while (IsTaken(free_name));
  return free_name;
}

const flatland_msgs::ModelInfo* WorldNames::FindTwin(const QString& file, const QString& ns) const {
  // The server looks up a relative name beside its world, and in its own folders.
  const QString path = QFileInfo(file).isRelative() ? QDir::cleanPath("/" + file)
                                                    : QFileInfo(file).canonicalFilePath();
  if (path.isEmpty()) return nullptr;  // there is no such file on this machine
  for (const flatland_msgs::ModelInfo& model : models_.models) {
    const QString known = QString::fromStdString(model.yaml_path);
    const bool is_same = QFileInfo(file).isRelative() ? known.endsWith(path) : known == path;
    if (is_same && model.ns == ns.toStdString() && HasTopics(model)) return &model;
  }
  return nullptr;
}

QString CommandTopic(const flatland_msgs::ModelInfo& model) {
  for (const flatland_msgs::PluginInfo& plugin : model.plugins) {
    for (const flatland_msgs::TopicInfo& topic : plugin.topics) {
      if (!topic.is_published && topic.type == "geometry_msgs/Twist") {
        return QString::fromStdString(topic.name);
      }
    }
  }
  return {};
}

}  // namespace flatland_viz
