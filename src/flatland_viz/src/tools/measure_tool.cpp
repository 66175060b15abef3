/// rviz's tool that measures distances on the floor.

#include <OgreSceneManager.h>
#include <OgreSceneNode.h>
#include <OgreViewport.h>
#include <rviz/display_context.h>
#include <rviz/render_panel.h>
#include <rviz/tool.h>
#include <rviz/view_controller.h>
#include <rviz/view_manager.h>
#include <rviz/viewport_mouse_event.h>

#include <QLineF>
#include <cmath>
#include <memory>
#include <pluginlib/class_list_macros.hpp>

#include "before_render.hpp"
#include "flat_shape.hpp"
#include "name_label.hpp"
#include "screen_scale.hpp"
#include "world_models.hpp"
#include "world_plane.hpp"

namespace flatland_viz {
namespace {

constexpr float kMeasureZ = 0.2f;                 // m: above the models
constexpr double kStillReach = 4;                 // pixels that the mouse may move in a click
constexpr double kLineWidth = 3, kEndRadius = 4;  // pixels: of the line, and the radius of its ends
const QColor kLineColor(0, 114, 178), kEdgeColor(255, 255, 255, 220);

}  // namespace

/// A line from where the left button is pressed to where it is released, or from one click to the
/// next, with its length beside it. rviz's own tool measures between things, and does nothing on
/// the floor. The last line stays until the tool is left, or another one begun.
class MeasureTool : public rviz::Tool {
 public:
  MeasureTool();
  ~MeasureTool() override;

  void activate() override;
  void deactivate() override;
  int processMouseEvent(rviz::ViewportMouseEvent& event) override;

 protected:
  void onInitialize() override;

 private:
  enum class Phase { kBefore, kPressed, kFollowing, kDone };

  void Show(const Ogre::Viewport& viewport, double pixel_ratio);
  void Tell();

  Phase phase_ = Phase::kBefore;
  QLineF line_;                      // in the world [m]
  Ogre::SceneNode* node_ = nullptr;  // belongs to the scene
  std::unique_ptr<FlatShape> shape_;
  std::unique_ptr<NameLabel> label_;
  std::unique_ptr<BeforeRender> before_render_;
};

MeasureTool::MeasureTool() { shortcut_key_ = 'm'; }

MeasureTool::~MeasureTool() {
  before_render_.reset();
  shape_.reset();
  label_.reset();
  if (node_) scene_manager_->destroySceneNode(node_);
}

void MeasureTool::onInitialize() {
  setName("Measure");
  setCursor(Qt::CrossCursor);
  node_ = scene_manager_->getRootSceneNode()->createChildSceneNode();
  shape_ = std::make_unique<FlatShape>(*scene_manager_, *node_, 2);
  label_ = std::make_unique<NameLabel>(*scene_manager_, *node_);
  before_render_ =
      std::make_unique<BeforeRender>(*context_, [this](const auto&... view) { Show(view...); });
}

void MeasureTool::activate() {
  phase_ = Phase::kBefore;
  Tell();
}

void MeasureTool::deactivate() {
  phase_ = Phase::kBefore;
  setStatus("");
  context_->queueRender();
}

int MeasureTool::processMouseEvent(rviz::ViewportMouseEvent& event) {
  const bool is_for_view = event.type == QEvent::Wheel || event.middle() || event.right() ||
                           event.acting_button == Qt::MiddleButton;
  const auto world = WorldPlane::Find(*context_);
  if (is_for_view || !world) {
    context_->getViewManager()->getCurrent()->handleMouseEvent(event);
    return Render;
  }
  const auto point = world->PointAt(event.viewport, event.x, event.y);
  if (!point) return 0;
  if (phase_ == Phase::kPressed || phase_ == Phase::kFollowing) {
    line_.setP2(*point);
  }
  // The second of two quick clicks arrives as a double click.
  const bool is_press =
      event.acting_button == Qt::LeftButton && event.left() && event.type != QEvent::MouseMove;
  if (is_press && phase_ == Phase::kFollowing) {
    phase_ = Phase::kDone;
  } else if (is_press) {
    phase_ = Phase::kPressed;
    line_ = QLineF(*point, *point);
  } else if (event.leftUp() && phase_ == Phase::kPressed) {
    const double scale =
        ScreenScale::At(world->PositionInScene({}, 0), *event.viewport).pixels_per_metre;
    const bool is_click = line_.length() * scale < kStillReach * event.panel->devicePixelRatioF();
    phase_ = is_click ? Phase::kFollowing : Phase::kDone;
  }
  Tell();
  return Render;
}

void MeasureTool::Tell() {
  if (phase_ == Phase::kBefore) {
    setStatus("<b>Drag</b>, or <b>click</b> twice: Measure a distance. <b>Esc:</b> Leave.");
    return;
  }
  const double angle = std::atan2(line_.dy(), line_.dx()) * 180 / M_PI;
  setStatus(QString("<b>%1 m</b> &nbsp; x %2 m, y %3 m, %4° &nbsp; <b>Esc:</b> Leave.")
                .arg(line_.length(), 0, 'f', 3)
                .arg(line_.dx(), 0, 'f', 3)
                .arg(line_.dy(), 0, 'f', 3)
                .arg(angle, 0, 'f', 1));
}

void MeasureTool::Show(const Ogre::Viewport& viewport, double pixel_ratio) {
  const auto world = WorldPlane::Find(*context_);
  const bool is_shown = phase_ != Phase::kBefore && world;
  shape_->SetVisible(is_shown);
  label_->SetVisible(is_shown);
  if (!is_shown) return;
  const geometry_msgs::Pose2D pose =
      MakePose(line_.x1(), line_.y1(), std::atan2(line_.dy(), line_.dx()));
  const Ogre::Vector3 at = world->PositionInScene(pose, kMeasureZ);
  const ScreenScale scale = ScreenScale::At(at, viewport);
  const float length = static_cast<float>(line_.length() * scale.pixels_per_metre);
  shape_->Begin();  // in pixels
  for (const bool is_edge : {true, false}) {
    const double edge = is_edge ? 1.5 : 0.0;
    const QColor& color = is_edge ? kEdgeColor : kLineColor;
    const float half = static_cast<float>((kLineWidth / 2 + edge) * pixel_ratio);
    shape_->AddTriangle({0, half}, {0, -half}, {length, half}, color);
    shape_->AddTriangle({length, half}, {0, -half}, {length, -half}, color);
    for (const float end : {0.0f, length}) {
      shape_->AddDisc({end, 0}, (kEndRadius + edge) * pixel_ratio, color);
    }
  }
  shape_->End();
  shape_->Place(at, world->OrientationInScene(pose), scale.Metres(1.0));
  shape_->SetVisible(true);

  label_->Set(QString("%1 m").arg(line_.length(), 0, 'f', 2), {Qt::white, kLineColor, pixel_ratio});
  const geometry_msgs::Pose2D middle = MakePose(line_.center().x(), line_.center().y());
  const double up = label_->size().height() + kEndRadius * pixel_ratio;
  label_->Place(world->PositionInScene(middle, kMeasureZ) + scale.Offset(0, up), viewport);
  label_->SetVisible(true);
}

}  // namespace flatland_viz

PLUGINLIB_EXPORT_CLASS(flatland_viz::MeasureTool, rviz::Tool)
