#pragma once

/// The model to spawn as properties of the tool, in rviz's panel and in its configuration file.

#include "model_choice.hpp"

namespace rviz {
class BoolProperty;
class IntProperty;
class Property;
class StringProperty;
}  // namespace rviz

namespace flatland_viz {

/// "Model File", "Name", "Namespace", "Number" and "Next Number".
class SpawnProperties {
 public:
  /// The properties belong to `container`.
  explicit SpawnProperties(rviz::Property* container);

  ModelChoice Read() const;
  void Write(const ModelChoice& choice);
  /// Tells the window the name of a model that was spawned, by a hidden property "Spawned".
  void Announce(const QString& name);

 private:
  rviz::StringProperty* file_;
  rviz::StringProperty* name_;
  rviz::StringProperty* namespace_;
  rviz::BoolProperty* is_numbered_;
  rviz::IntProperty* number_;
  rviz::StringProperty* spawned_;
};

}  // namespace flatland_viz
