#pragma once

/// The model to spawn, and its name.

#include <QString>

namespace flatland_viz {

struct ModelChoice {
  QString file;
  QString own_name;       ///< given by the user; if empty, the name is taken from the file
  QString proposed_name;  ///< instead of the file's, if that is taken; empty if it is not
  QString own_ns;         ///< given by the user: in front of the model's topics and frames
  QString proposed_ns;    ///< used if the user has given none
  bool is_numbered = false;
  int number = 1;  ///< appended to the name, if it is numbered

  /// The name of the model, such as "box" or "box_1".
  QString Name() const;
  /// The namespace of the model; empty for none. A proposed one is for a copy, which gets a frame
  /// of odometry of its own by "~".
  QString Namespace() const;
};

/// The name of a file without its folder and endings: "box" for "/models/box.model.yaml".
QString NameFromFile(const QString& file);

}  // namespace flatland_viz
