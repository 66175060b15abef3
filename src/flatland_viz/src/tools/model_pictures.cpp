#include "model_pictures.hpp"

#include <flatland_msgs/GetModelMarkers.h>

#include <QGuiApplication>
#include <QPainter>
#include <algorithm>
#include <cmath>

namespace flatland_viz {
namespace {

using flatland_msgs::GetModelMarkers;
using visualization_msgs::Marker;

constexpr int kPictureSize = 48;
constexpr double kEmptyPart = 0.06;  // of the picture, on each side

/// Where a point of a marker is, seen from above [m].
QPointF Seen(const Marker& marker, const geometry_msgs::Point& point) {
  const geometry_msgs::Quaternion& q = marker.pose.orientation;
  const double yaw = std::atan2(2 * (q.w * q.z + q.x * q.y), 1 - 2 * (q.y * q.y + q.z * q.z));
  const double c = std::cos(yaw), s = std::sin(yaw);
  return {marker.pose.position.x + c * point.x - s * point.y,
          marker.pose.position.y + s * point.x + c * point.y};
}

QColor ColorOf(const Marker& marker) {
  const auto channel = [](float value) { return std::clamp(static_cast<double>(value), 0.0, 1.0); };
  return QColor::fromRgbF(channel(marker.color.r), channel(marker.color.g), channel(marker.color.b),
                          channel(marker.color.a));
}

QRectF BoundsOf(const visualization_msgs::MarkerArray& markers) {
  QPolygonF points;
  for (const Marker& marker : markers.markers) {
    for (const auto& point : marker.points) points << Seen(marker, point);
  }
  return points.boundingRect();
}

}  // namespace

void ModelPictures::Ask(const QStringList& files) {
  files_ = files;
  server_.Cancel();
  AskNext();
}

void ModelPictures::AskNext() {
  if (files_.isEmpty()) return;
  const QString file = files_.takeFirst();
  GetModelMarkers::Request request;
  request.yaml_path = file.toStdString();
  server_.Call<GetModelMarkers>(
      "/get_model_markers", request,
      [this, file](const QString& error, const GetModelMarkers::Response& response) {
        if (error.isEmpty() && response.success) {
          Q_EMIT Drawn(file,
                       PictureOf(response.markers, kPictureSize, qGuiApp->devicePixelRatio()));
        }
        AskNext();
      });
}

QImage PictureOf(const visualization_msgs::MarkerArray& markers, int pixels, double pixel_ratio) {
  const int size = static_cast<int>(std::lround(pixels * pixel_ratio));
  QImage picture(size, size, QImage::Format_ARGB32_Premultiplied);
  picture.fill(Qt::transparent);
  const QRectF bounds = BoundsOf(markers);
  const double side = std::max({bounds.width(), bounds.height(), 1e-3});
  QPainter painter(&picture);
  painter.setRenderHint(QPainter::Antialiasing);
  painter.translate(size / 2.0, size / 2.0);
  painter.scale((1 - 2 * kEmptyPart) * size / side, -(1 - 2 * kEmptyPart) * size / side);
  painter.translate(-bounds.center());
  for (const Marker& marker : markers.markers) {
    QPen pen(ColorOf(marker));
    pen.setCosmetic(true);
    const std::size_t corners = marker.type == Marker::TRIANGLE_LIST ? 3 : 2;
    painter.setBrush(corners == 3 ? QBrush(pen.color()) : QBrush(Qt::NoBrush));
    painter.setPen(pen);
    for (std::size_t i = 0; i + corners <= marker.points.size(); i += corners) {
      QPolygonF shape;
      for (std::size_t k = i; k < i + corners; ++k) shape << Seen(marker, marker.points[k]);
      painter.drawPolygon(shape);
    }
  }
  painter.end();
  picture.setDevicePixelRatio(pixel_ratio);
  return picture;
}

}  // namespace flatland_viz
