#include "spawn_properties.hpp"

#include <rviz/properties/bool_property.h>
#include <rviz/properties/int_property.h>
#include <rviz/properties/string_property.h>

namespace flatland_viz {

SpawnProperties::SpawnProperties(rviz::Property* container)
    : file_(new rviz::StringProperty("Model File", "", "The YAML file of the model to spawn.",
                                     container)),
      name_(new rviz::StringProperty(
          "Name", "", "The name of the model; if empty, it is taken from the file.", container)),
      namespace_(new rviz::StringProperty(
          "Namespace", "", "In front of the names of the model's topics and frames.", container)),
      is_numbered_(new rviz::BoolProperty(
          "Number", false, "Whether a number that counts up is appended to the name.", container)),
      number_(new rviz::IntProperty("Next Number", 1, "The number of the next model.", container)),
      spawned_(new rviz::StringProperty("Spawned", "", "", container)) {
  spawned_->setHidden(true);
  spawned_->setShouldBeSaved(false);
  number_->setMin(0);
  number_->setShouldBeSaved(false);  // the next simulation starts without models
}

ModelChoice SpawnProperties::Read() const {
  ModelChoice choice;
  choice.file = file_->getString();
  choice.own_name = name_->getString();
  choice.own_ns = namespace_->getString();
  choice.is_numbered = is_numbered_->getBool();
  choice.number = number_->getInt();
  return choice;
}

void SpawnProperties::Write(const ModelChoice& choice) {
  file_->setString(choice.file);
  name_->setString(choice.own_name);
  namespace_->setString(choice.own_ns);
  is_numbered_->setBool(choice.is_numbered);
  number_->setInt(choice.number);
}

void SpawnProperties::Announce(const QString& name) {
  spawned_->setString("");  // one of this name may have been spawned before
  spawned_->setString(name);
}

}  // namespace flatland_viz
