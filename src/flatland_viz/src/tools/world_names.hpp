#pragma once

/// Names and namespaces that must be unique among the models in the world.

#include <flatland_msgs/ModelList.h>

#include <QString>

namespace flatland_viz {

class WorldNames {
 public:
  WorldNames() = default;
  explicit WorldNames(const flatland_msgs::ModelList& models) : models_(models) {}

  bool IsTaken(const QString& name) const;

  /// The name, or if it is taken, the same with the next number that is free: box_2, r3 for r2.
  QString FreeName(const QString& name) const;

  /// A model of the same file and namespace: it would have the same topics. Null if there is none,
  /// or if models of that file have no topics.
  const flatland_msgs::ModelInfo* FindTwin(const QString& file, const QString& ns) const;

 private:
  flatland_msgs::ModelList models_;
};

/// The topic of a model's velocity commands; empty if it has no drive.
QString CommandTopic(const flatland_msgs::ModelInfo& model);

}  // namespace flatland_viz
