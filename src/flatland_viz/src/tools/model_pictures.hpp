#pragma once

/// Pictures of model files, as the server draws them.

#include <visualization_msgs/MarkerArray.h>

#include <QImage>
#include <QObject>
#include <QStringList>

#include "service_caller.hpp"

namespace flatland_viz {

/// Asks the server for one model after the other.
class ModelPictures : public QObject {
  Q_OBJECT

 public:
  /// Asks for the pictures of these files, instead of those that were still to come. A file that
  /// the server refuses has none.
  void Ask(const QStringList& files);

 Q_SIGNALS:
  void Drawn(const QString& file, const QImage& picture);

 private:
  void AskNext();

  QStringList files_;
  ServiceCaller server_;
};

/// A model seen from above, as large as fits; x points to the right.
QImage PictureOf(const visualization_msgs::MarkerArray& markers, int pixels, double pixel_ratio);

}  // namespace flatland_viz
