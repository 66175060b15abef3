#pragma once

/// Properties of tools and displays through which the window, which is in Python, reads and sets
/// values.

#include <rviz/properties/property.h>

namespace flatland_viz {

/// A property that rviz neither shows nor saves.
inline rviz::Property* WindowProperty(const char* name, rviz::Property* parent,
                                      const QVariant& value = "") {
  auto* property = new rviz::Property(name, value, "", parent);
  property->setHidden(true);
  property->setShouldBeSaved(false);
  return property;
}

/// Tells the window that something has happened to a model, perhaps once more to the same one.
inline void Announce(rviz::Property* property, const QString& model) {
  property->setValue("");
  property->setValue(model);
}

}  // namespace flatland_viz
