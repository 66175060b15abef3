/// The default tool: looking around, selecting, dragging and turning models.

#include <OgreViewport.h>
#include <ros/time.h>
#include <rviz/display_context.h>
#include <rviz/load_resource.h>
#include <rviz/render_panel.h>
#include <rviz/tool.h>
#include <rviz/view_controller.h>
#include <rviz/view_manager.h>
#include <rviz/viewport_mouse_event.h>

#include <QCursor>
#include <QLineF>
#include <QPointF>
#include <cmath>
#include <memory>
#include <optional>
#include <pluginlib/class_list_macros.hpp>
#include <string>

#include "before_render.hpp"
#include "model_drag.hpp"
#include "model_handle.hpp"
#include "screen_scale.hpp"
#include "window_property.hpp"
#include "world_models.hpp"
#include "world_plane.hpp"

namespace flatland_viz {
namespace {

constexpr double kClickReach = 4;  // pixels that the mouse may move in a click
constexpr double kMinTarget = 10;  // pixels around a small model's middle that belong to it
constexpr double kRingReach = 6;   // pixels on either side of a ring
const ros::WallDuration kStatePeriod(0.2);

double Distance(const QPointF& a, const QPointF& b) { return QLineF(a, b).length(); }

}  // namespace

/// A click selects a model, a drag moves it, a drag of its ring turns it; all else goes to the
/// view.
///
/// Its properties connect it with the window's panels: "Selected" is the name of the selected
/// model, "State" its pose and velocity, "Dragged" the model that was dragged last, "Menu" that of
/// which the user asks for the context menu. All but "Selected" are for reading.
class InteractTool : public rviz::Tool {
 public:
  InteractTool();
  ~InteractTool() override;

  void activate() override {}
  void deactivate() override;
  int processMouseEvent(rviz::ViewportMouseEvent& event) override;
  void update(float wall_dt, float ros_dt) override;

 protected:
  void onInitialize() override;

 private:
  enum class Part { kNone, kBody, kRing };
  struct Hit {
    Part part = Part::kNone;
    std::string model;
  };
  struct Press {
    Qt::MouseButton button;
    QPointF pixel;  ///< in the panel
    QPointF at;     ///< in the world [m]
    Hit hit;
  };

  /// Finds the model or ring at a point of the world [m]. `pixel`: the size of one of Qt's pixels
  /// there [m].
  Hit FindHit(const QPointF& at, double pixel) const;
  /// Notes the model that the mouse has reached or not left yet, with its ring.
  void FollowHover(const Hit& hit, const QPointF& at, double pixel);
  int Release(rviz::ViewportMouseEvent& event);
  void BeginDrag();
  void ContinueDrag(const QPointF& at);
  void EndDrag();
  void PassOn(rviz::ViewportMouseEvent& event);
  void ShowHint(const Hit& hit);
  void ShowHandles(const Ogre::Viewport& viewport, double pixel_ratio);
  void TellState();

  rviz::Property* selected_;
  rviz::Property* state_;
  rviz::Property* dragged_;
  rviz::Property* menu_;

  std::shared_ptr<WorldModels> models_;
  std::unique_ptr<ModelHandle> hovered_handle_, selected_handle_;
  std::unique_ptr<BeforeRender> before_render_;
  ModelDrag drag_;
  QPointF turn_middle_;  // of the model that is being turned, in the world [m]
  std::optional<Press> press_;
  bool is_panning_ = false;             // the view has the mouse until the button is released
  rviz::RenderPanel* panel_ = nullptr;  // with the mouse; known after the first event
  ros::WallTime told_at_;
};

InteractTool::InteractTool()
    : selected_(WindowProperty("Selected", getPropertyContainer())),
      state_(WindowProperty("State", getPropertyContainer(), QVariantMap())),
      dragged_(WindowProperty("Dragged", getPropertyContainer())),
      menu_(WindowProperty("Menu", getPropertyContainer())) {
  shortcut_key_ = 'i';
}

InteractTool::~InteractTool() = default;

void InteractTool::onInitialize() {
  setName("Interact");
  setCursor(Qt::ArrowCursor);
  models_ = WorldModels::Of(*context_);
  hovered_handle_ = std::make_unique<ModelHandle>(*scene_manager_);
  selected_handle_ = std::make_unique<ModelHandle>(*scene_manager_);
  before_render_ = std::make_unique<BeforeRender>(
      *context_, [this](const auto&... view) { ShowHandles(view...); });
  connect(models_.get(), &WorldModels::Selected, this, [this] {
    selected_->setValue(QString::fromStdString(models_->selected()));
    told_at_ = ros::WallTime();
  });
  connect(selected_, &rviz::Property::changed, this, [this] {
    models_->Select(selected_->getValue().toString().toStdString());
    context_->queueRender();
  });
}

void InteractTool::deactivate() {
  drag_.Cancel();
  models_->SetDragged("");
  press_.reset();
  is_panning_ = false;
  models_->Hover("");
}

int InteractTool::processMouseEvent(rviz::ViewportMouseEvent& event) {
  panel_ = event.panel;
  const auto world = WorldPlane::Find(*context_);
  const auto at = world ? world->PointAt(event.viewport, event.x, event.y) : std::nullopt;
  if (!at) {
    PassOn(event);
    return 0;
  }
  if (drag_.is_active()) {
    if (event.leftUp()) {
      EndDrag();
    } else if (event.type == QEvent::MouseMove) {
      ContinueDrag(*at);
    }
    return Render;
  }
  if (event.type == QEvent::MouseButtonRelease) return Release(event);

  const double ratio = panel_->devicePixelRatioF();
  const QPointF place(event.x, event.y);
  if (event.buttons_down == Qt::NoButton || !press_) {
    const double pixel =
        ScreenScale::At(world->PositionInScene({}, 0), *event.viewport).Metres(ratio);
    const Hit hit = FindHit(*at, pixel);
    FollowHover(hit, *at, pixel);
    if (event.type == QEvent::MouseButtonPress) {
      press_ = Press{event.acting_button, place, *at, hit};
      is_panning_ =
          hit.part == Part::kNone || event.control() || event.acting_button == Qt::MiddleButton;
    }
    ShowHint(hit);
    if (hit.part != Part::kNone && event.type != QEvent::Wheel && !is_panning_) {
      setCursor(hit.part == Part::kBody ? QCursor(Qt::OpenHandCursor)
                                        : rviz::makeIconCursor("package://rviz/icons/rotate.svg"));
      return Render;
    }
  } else if (!is_panning_ && Distance(place, press_->pixel) > kClickReach * ratio) {
    if (press_->button == Qt::LeftButton) {
      BeginDrag();
      ContinueDrag(*at);
      return Render;
    }
    is_panning_ = true;  // the right button zooms wherever it is pressed
  }
  if (press_ && !is_panning_) return 0;
  PassOn(event);
  return Render;
}

int InteractTool::Release(rviz::ViewportMouseEvent& event) {
  const double reach = kClickReach * panel_->devicePixelRatioF();
  const bool is_click = press_ && event.acting_button == press_->button && !event.control() &&
                        Distance(QPointF(event.x, event.y), press_->pixel) <= reach;
  const std::string model = press_ ? press_->hit.model : "";  // empty beside the models
  if (is_panning_) PassOn(event);
  if (event.buttons_down == Qt::NoButton) {
    press_.reset();
    is_panning_ = false;
  }
  if (is_click && event.acting_button == Qt::LeftButton) {
    models_->Select(model);
  } else if (is_click && event.acting_button == Qt::RightButton && !model.empty()) {
    models_->Select(model);
    Announce(menu_, QString::fromStdString(model));
  }
  return Render;
}

InteractTool::Hit InteractTool::FindHit(const QPointF& at, double pixel) const {
  Hit hit;
  double smallest = 0.0;
  for (const auto& [name, model] : models_->models()) {
    if (!model.is_placed()) continue;
    const bool is_near = Distance(at, model.middle_in_world()) <= kMinTarget * pixel;
    if (!is_near && !model.Contains(at)) continue;
    const double radius = model.radius();
    if (hit.part == Part::kNone || radius < smallest) {
      hit = {Part::kBody, name};
      smallest = radius;
    }
  }
  if (hit.part != Part::kNone) return hit;
  for (const std::string& name : {models_->hovered(), models_->selected()}) {
    const WorldModel* model = models_->Find(name);
    if (!model || !model->is_placed()) continue;
    const double ring = ModelHandle::Radius(*model, pixel);
    const double distance = Distance(at, model->middle_in_world());
    if (std::abs(distance - ring) <= kRingReach * pixel) return {Part::kRing, name};
  }
  return hit;
}

void InteractTool::FollowHover(const Hit& hit, const QPointF& at, double pixel) {
  const WorldModel* before = models_->Find(models_->hovered());
  const bool is_still_within = hit.part == Part::kNone && before && before->is_placed() &&
                               Distance(at, before->middle_in_world()) <
                                   ModelHandle::Radius(*before, pixel) + kRingReach * pixel;
  if (!is_still_within) models_->Hover(hit.model);
}

void InteractTool::BeginDrag() {
  const WorldModel* model = models_->Find(press_->hit.model);
  if (!model) return;
  turn_middle_ = model->middle_in_world();
  models_->Select(model->info.name);
  drag_.Begin(model->info.name, model->state.pose, press_->at);
  models_->SetDragged(model->info.name);
  setCursor(Qt::ClosedHandCursor);
  setStatus("<b>Esc:</b> Put it back. The simulation waits.");
}

void InteractTool::ContinueDrag(const QPointF& at) {
  if (!drag_.is_active()) return;  // the model was gone
  press_->hit.part == Part::kBody ? drag_.MoveTo(at) : drag_.TurnTo(at, turn_middle_);
}

void InteractTool::EndDrag() {
  drag_.End();
  models_->SetDragged("");
  press_.reset();
  Announce(dragged_, QString::fromStdString(drag_.model()));
}

void InteractTool::PassOn(rviz::ViewportMouseEvent& event) {
  rviz::ViewController* view = context_->getViewManager()->getCurrent();
  view->handleMouseEvent(event);
  setCursor(view->getCursor());
}

void InteractTool::ShowHint(const Hit& hit) {
  if (hit.part == Part::kNone) return;  // the view has its own
  setStatus(
      QString("<b>%1</b> &nbsp; <b>Click:</b> Select. <b>Drag:</b> %2. <b>Right-Click:</b> Menu.")
          .arg(QString::fromStdString(hit.model).toHtmlEscaped(),
               hit.part == Part::kBody ? "Move" : "Turn"));
}

void InteractTool::update(float /*wall_dt*/, float /*ros_dt*/) {
  drag_.KeepAlive();
  const bool is_over_view =
      panel_ && panel_->rect().contains(panel_->mapFromGlobal(QCursor::pos()));
  if (!is_over_view && !press_) models_->Hover("");  // no event tells that the mouse has left
  TellState();
}

void InteractTool::ShowHandles(const Ogre::Viewport& viewport, double pixel_ratio) {
  const auto world = WorldPlane::Find(*context_);
  const auto show = [&](ModelHandle& handle, const std::string& name, bool is_strong) {
    const WorldModel* model = models_->Find(name);
    if (!world || !model || !model->is_placed()) {
      handle.Hide();
      return;
    }
    const bool is_dragged = drag_.is_active() && drag_.model() == name;
    handle.Show(*model, is_dragged ? drag_.pose() : model->state.pose, *world, viewport,
                pixel_ratio, is_strong);
  };
  show(*selected_handle_, models_->selected(), true);
  show(*hovered_handle_, models_->hovered() == models_->selected() ? "" : models_->hovered(),
       false);
}

void InteractTool::TellState() {
  const ros::WallTime now = ros::WallTime::now();
  if (now - told_at_ < kStatePeriod) return;
  told_at_ = now;
  const WorldModel* model = models_->Find(models_->selected());
  if (!model || !model->is_placed()) {
    state_->setValue(QVariantMap());
    return;
  }
  const geometry_msgs::Pose2D& pose = model->state.pose;
  const geometry_msgs::Twist& twist = model->state.twist;
  state_->setValue(QVariantMap{{"name", QString::fromStdString(model->info.name)},
                               {"x", pose.x},
                               {"y", pose.y},
                               {"theta", pose.theta},
                               {"vx", twist.linear.x},
                               {"vy", twist.linear.y},
                               {"omega", twist.angular.z}});
}

}  // namespace flatland_viz

PLUGINLIB_EXPORT_CLASS(flatland_viz::InteractTool, rviz::Tool)
