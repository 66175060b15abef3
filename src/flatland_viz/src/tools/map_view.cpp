/// rviz's view from above, with the mouse of maps.

#include <OgreViewport.h>
#include <ros/time.h>
#include <rviz/default_plugin/view_controllers/fixed_orientation_ortho_view_controller.h>
#include <rviz/display_context.h>
#include <rviz/properties/float_property.h>
#include <rviz/properties/string_property.h>
#include <rviz/render_panel.h>
#include <rviz/viewport_mouse_event.h>

#include <QPointF>
#include <algorithm>
#include <cmath>
#include <memory>
#include <optional>
#include <pluginlib/class_list_macros.hpp>
#include <string>

#include "world_models.hpp"
#include "world_plane.hpp"

namespace flatland_viz {
namespace {

constexpr double kZoomPerWheelUnit = 0.001;  // as rviz's views: 12 % for each click of the wheel
constexpr double kZoomPerPixel = 0.01;
constexpr double kMinScale = 0.01, kMaxScale = 1e5;  // pixels per metre
const ros::WallDuration kSettling(0.3);              // until the last state of a drag has come
constexpr double kStillMiddle = 20;                  // pixels: nearer, a rotation is not defined

}  // namespace

/// A drag with the left or middle button pans, the wheel zooms at the cursor, and a drag with Ctrl
/// rotates about the middle. It has the properties of rviz's TopDownOrtho, and "Follow", the name
/// of a model that the view moves along with, except while the mouse drags it.
class MapView : public rviz::FixedOrientationOrthoViewController {
 public:
  MapView();

  void update(float dt, float ros_dt) override;
  void handleMouseEvent(rviz::ViewportMouseEvent& event) override;

 protected:
  void onInitialize() override;

 private:
  void Pan(const QPointF& pixels);
  void Zoom(double factor, const QPointF& from_middle);
  void Rotate(const QPointF& before, const QPointF& now);
  void Follow();

  rviz::StringProperty* follow_;
  std::shared_ptr<WorldModels> models_;
  std::string followed_;                  // since the last update
  std::optional<QPointF> followed_from_;  // where it was then, in the target frame [m]
  ros::WallTime rests_until_;             // while the followed model is dragged, and a little after
};

MapView::MapView()
    : follow_(new rviz::StringProperty("Follow", "", "The model that the view moves along with.",
                                       this)) {
  follow_->setShouldBeSaved(false);
}

void MapView::onInitialize() {
  FixedOrientationOrthoViewController::onInitialize();
  models_ = WorldModels::Of(*context_);
  setCursor(Qt::ArrowCursor);
}

void MapView::handleMouseEvent(rviz::ViewportMouseEvent& event) {
  setStatus(
      "<b>Drag:</b> Move the map. <b>Wheel:</b> Zoom. <b>Ctrl-Drag:</b> Rotate. <b>Home:</b> Show "
      "all.");
  // rviz gives the mouse's position in device pixels, the unit of the scale.
  const QPointF middle(0.5 * event.viewport->getActualWidth(),
                       0.5 * event.viewport->getActualHeight());
  const QPointF now = QPointF(event.x, event.y) - middle;
  const QPointF before = QPointF(event.last_x, event.last_y) - middle;
  const bool has_moved = event.type == QEvent::MouseMove && now != before;

  if (event.type == QEvent::Wheel) {
    Zoom(1.0 + kZoomPerWheelUnit * std::clamp(event.wheel_delta, -600, 600), now);
  } else if (has_moved && event.left() && event.control()) {
    setCursor(Rotate2D);
    Rotate(before, now);
  } else if (has_moved && (event.left() || event.middle())) {
    setCursor(Qt::ClosedHandCursor);
    Pan(now - before);
  } else if (has_moved && event.right()) {
    setCursor(rviz::ViewController::Zoom);
    const double ratio = event.panel->devicePixelRatioF();
    Zoom(1.0 - kZoomPerPixel * (now - before).y() / ratio, QPointF());
  } else {
    if (event.buttons_down == Qt::NoButton) setCursor(Qt::ArrowCursor);
    return;
  }
  emitConfigChanged();
  context_->queueRender();
}

void MapView::Pan(const QPointF& pixels) {
  const float scale = scale_property_->getFloat();
  move(static_cast<float>(-pixels.x()) / scale, static_cast<float>(pixels.y()) / scale);
}

void MapView::Zoom(double factor, const QPointF& from_middle) {
  const double before = scale_property_->getFloat();
  const double after = std::clamp(before * std::max(factor, 0.1), kMinScale, kMaxScale);
  scale_property_->setFloat(static_cast<float>(after));
  const double shift = 1.0 / before - 1.0 / after;  // of the point under the cursor
  move(static_cast<float>(from_middle.x() * shift), static_cast<float>(-from_middle.y() * shift));
}

void MapView::Rotate(const QPointF& before, const QPointF& now) {
  if (std::min(std::hypot(before.x(), before.y()), std::hypot(now.x(), now.y())) < kStillMiddle) {
    return;
  }
  const double turn = std::atan2(now.y(), now.x()) - std::atan2(before.y(), before.x());
  angle_property_->add(static_cast<float>(std::remainder(turn, 2 * M_PI)));
}

void MapView::update(float dt, float ros_dt) {
  Follow();
  FixedOrientationOrthoViewController::update(dt, ros_dt);
}

void MapView::Follow() {
  const std::string name = follow_->getStdString();
  const WorldModel* model = models_->Find(name);
  const auto world = WorldPlane::Find(*context_);
  if (!model || !model->is_placed() || !world) {
    followed_from_.reset();
    return;
  }
  const Ogre::Vector3 position =
      reference_orientation_.Inverse() *
      (world->PositionInScene(model->state.pose, 0) - reference_position_);
  const QPointF at(position.x, position.y);
  // If the view followed the model, the point under the mouse would move on with both.
  const ros::WallTime time = ros::WallTime::now();
  if (models_->dragged() == name) rests_until_ = time + kSettling;
  if (time < rests_until_ && followed_ == name) {
    followed_from_ = at;
    return;
  }
  if (!followed_from_ || followed_ != name) {  // to the middle; later the user may move the map
    x_property_->setFloat(position.x);
    y_property_->setFloat(position.y);
  } else if (at != *followed_from_) {
    x_property_->add(static_cast<float>(at.x() - followed_from_->x()));
    y_property_->add(static_cast<float>(at.y() - followed_from_->y()));
  } else {
    return;
  }
  followed_ = name;
  followed_from_ = at;
  context_->queueRender();
}

}  // namespace flatland_viz

PLUGINLIB_EXPORT_CLASS(flatland_viz::MapView, rviz::ViewController)
