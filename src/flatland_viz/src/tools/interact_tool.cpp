#include "interact_tool.hpp"

#include <OgreViewport.h>
#include <rviz/display_context.h>
#include <rviz/load_resource.h>
#include <rviz/properties/bool_property.h>
#include <rviz/properties/string_property.h>
#include <rviz/render_panel.h>
#include <rviz/view_controller.h>
#include <rviz/view_manager.h>
#include <rviz/viewport_mouse_event.h>

#include <QApplication>
#include <QCursor>
#include <QJsonDocument>
#include <QJsonObject>
#include <algorithm>
#include <cmath>

#include "before_render.hpp"
#include "screen_scale.hpp"
#include "world_models.hpp"
#include "world_plane.hpp"

namespace flatland_viz {
namespace {

constexpr double kClickReach = 4;  // pixels that the mouse may move in a click
constexpr double kMinTarget = 10;  // pixels around a small model's middle that belong to it
constexpr double kRingReach = 6;   // pixels on either side of a ring
const ros::WallDuration kStatePeriod(0.2), kLookPeriod(0.2);

double Distance(const QPointF& a, const QPointF& b) {
  return std::hypot(a.x() - b.x(), a.y() - b.y());
}

rviz::StringProperty* HiddenProperty(const QString& name, rviz::Property* container) {
  auto* property = new rviz::StringProperty(name, "", "", container);
  property->setHidden(true);
  property->setShouldBeSaved(false);
  return property;
}

}  // namespace

InteractTool::InteractTool()
    : handles_are_shown_(new rviz::BoolProperty(
          "Handles", true, "Rings around models, to turn them.", getPropertyContainer())),
      selected_(HiddenProperty("Selected", getPropertyContainer())),
      state_(HiddenProperty("State", getPropertyContainer())),
      dragged_(HiddenProperty("Dragged", getPropertyContainer())),
      menu_(HiddenProperty("Menu", getPropertyContainer())) {
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
      *context_, [this](const Ogre::Viewport& viewport, double pixel_ratio) {
        ShowHandles(viewport, pixel_ratio);
      });
  connect(models_.get(), &WorldModels::Selected, this, [this] {
    selected_->setString(QString::fromStdString(models_->selected()));
    told_at_ = ros::WallTime();
  });
  connect(selected_, &rviz::Property::changed, this, [this] {
    models_->Select(selected_->getStdString());
    context_->queueRender();
  });
}

void InteractTool::activate() { is_active_ = true; }

void InteractTool::deactivate() {
  is_active_ = false;
  drag_.Cancel();
  models_->SetDragged("");
  press_.reset();
  is_panning_ = false;
  models_->Hover("");
  tooltip_.Hide();
}

int InteractTool::processMouseEvent(rviz::ViewportMouseEvent& event) {
  panel_ = event.panel;
  const double ratio = panel_->devicePixelRatioF();
  const auto world = WorldPlane::Find(*context_);
  const auto point = world ? world->PointAt(event.viewport, event.x, event.y) : std::nullopt;
  if (!point) {
    PassOn(event);
    return 0;
  }
  const QPointF at(point->x, point->y), pixel(event.x, event.y);
  if (drag_.is_active()) {
    if (event.leftUp()) {
      EndDrag();
    } else if (event.type == QEvent::MouseMove) {
      dragged_part_ == Part::kBody ? drag_.MoveTo(at) : drag_.TurnTo(at, turn_middle_);
    }
    return Render;
  }
  if (event.type == QEvent::MouseButtonRelease) return Release(event);

  const double scale =
      ScreenScale::At(world->PositionInScene({}, 0), *event.viewport).pixels_per_metre;
  if (event.buttons_down == Qt::NoButton || !press_) {
    const Hit hit = FindHit(at, scale, ratio);
    FollowHover(hit, at, scale, ratio);
    if (event.type == QEvent::MouseButtonPress) {
      press_ = Press{event.acting_button, pixel, at, hit};
      is_panning_ =
          hit.part == Part::kNone || event.control() || event.acting_button == Qt::MiddleButton;
    }
    ShowHint(hit);
    if (hit.part != Part::kNone && event.type != QEvent::Wheel && !is_panning_) {
      setCursor(hit.part == Part::kBody ? QCursor(Qt::OpenHandCursor)
                                        : rviz::makeIconCursor("package://rviz/icons/rotate.svg"));
      return Render;
    }
  } else if (!is_panning_ && Distance(pixel, press_->pixel) > kClickReach * ratio) {
    if (press_->button == Qt::LeftButton) {
      BeginDrag(at);
      return Render;
    }
    is_panning_ = true;  // the right button zooms wherever it is pressed
  }
  if (press_ && !is_panning_) return 0;
  PassOn(event);
  return Render;
}

int InteractTool::Release(rviz::ViewportMouseEvent& event) {
  const bool is_click = press_ && event.acting_button == press_->button &&
                        Distance({double(event.x), double(event.y)}, press_->pixel) <=
                            kClickReach * panel_->devicePixelRatioF();
  const std::string model = press_ ? press_->hit.model : "";
  const bool is_on_model = press_ && press_->hit.part != Part::kNone;
  if (is_panning_) PassOn(event);
  if (event.buttons_down == Qt::NoButton) {
    press_.reset();
    is_panning_ = false;
  }
  if (!is_click || event.control()) return Render;
  if (event.acting_button == Qt::LeftButton) {
    models_->Select(is_on_model ? model : "");
  } else if (event.acting_button == Qt::RightButton && is_on_model) {
    models_->Select(model);
    tooltip_.Hide();
    menu_->setString("");  // the same model may be asked for again
    menu_->setString(QString::fromStdString(model));
  }
  return Render;
}

InteractTool::Hit InteractTool::FindHit(const QPointF& at, double pixels_per_metre,
                                        double pixel_ratio) const {
  Hit hit;
  double smallest = 0.0;
  for (const auto& [name, model] : models_->models()) {
    if (!model.is_placed()) continue;
    const double target = kMinTarget * pixel_ratio / pixels_per_metre;
    if (!model.Contains(at.x(), at.y()) && Distance(at, model.middle_in_world()) > target) continue;
    const double radius = model.radius();
    if (hit.part == Part::kNone || radius < smallest) {
      hit = {Part::kBody, name};
      smallest = radius;
    }
  }
  if (hit.part != Part::kNone || !handles_are_shown_->getBool()) return hit;
  for (const std::string& name : {models_->hovered(), models_->selected()}) {
    const WorldModel* model = models_->Find(name);
    if (!model || !model->is_placed()) continue;
    const double ring = ModelHandle::Radius(*model, pixels_per_metre, pixel_ratio);
    const double distance = Distance(at, model->middle_in_world());
    const double reach = kRingReach * pixel_ratio / pixels_per_metre;
    if (std::abs(distance - ring) <= reach) return {Part::kRing, name};
  }
  return hit;
}

void InteractTool::FollowHover(const Hit& hit, const QPointF& at, double pixels_per_metre,
                               double pixel_ratio) {
  std::string name = hit.model;
  if (hit.part == Part::kNone) {
    const WorldModel* before = models_->Find(models_->hovered());
    if (before && before->is_placed()) {
      const double ring = ModelHandle::Radius(*before, pixels_per_metre, pixel_ratio);
      const double reach = kRingReach * pixel_ratio / pixels_per_metre;
      if (Distance(at, before->middle_in_world()) < ring + reach) name = before->info.name;
    }
  }
  if (name == models_->hovered()) return;
  models_->Hover(name);
  tooltip_.Restart();
}

void InteractTool::LookUnderMouse() {
  const ros::WallTime now = ros::WallTime::now();
  if (!panel_ || !is_active_ || press_ || models_->revision() == looked_revision_ ||
      now - looked_at_ < kLookPeriod) {
    return;
  }
  looked_at_ = now;
  looked_revision_ = models_->revision();
  const QPoint mouse = panel_->mapFromGlobal(QCursor::pos());
  const double ratio = panel_->devicePixelRatioF();
  const auto world = WorldPlane::Find(*context_);
  if (!world || !panel_->rect().contains(mouse)) return;
  Ogre::Viewport* viewport = panel_->getViewport();
  const auto point = world->PointAt(viewport, static_cast<int>(mouse.x() * ratio),
                                    static_cast<int>(mouse.y() * ratio));
  if (!point) return;
  const QPointF at(point->x, point->y);
  const double scale = ScreenScale::At(world->PositionInScene({}, 0), *viewport).pixels_per_metre;
  FollowHover(FindHit(at, scale, ratio), at, scale, ratio);
}

void InteractTool::BeginDrag(const QPointF& at) {
  const WorldModel* model = models_->Find(press_->hit.model);
  if (!model) return;
  dragged_part_ = press_->hit.part;
  turn_middle_ = model->middle_in_world();
  models_->Select(model->info.name);
  tooltip_.Hide();
  drag_.Begin(model->info.name, model->state.pose, press_->at);
  models_->SetDragged(model->info.name);
  dragged_part_ == Part::kBody ? drag_.MoveTo(at) : drag_.TurnTo(at, turn_middle_);
  setCursor(Qt::ClosedHandCursor);
  setStatus("<b>Esc:</b> Put it back. The simulation waits.");
}

void InteractTool::EndDrag() {
  drag_.End();
  models_->SetDragged("");
  press_.reset();
  dragged_->setString("");  // the same model may have been dragged before
  dragged_->setString(QString::fromStdString(drag_.model()));
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
  LookUnderMouse();
  ShowTooltip();
  TellState();
}

void InteractTool::ShowHandles(const Ogre::Viewport& viewport, double pixel_ratio) {
  const auto world = WorldPlane::Find(*context_);
  const auto show = [&](ModelHandle& handle, const std::string& name, bool is_strong) {
    const WorldModel* model = models_->Find(name);
    if (!world || !model || !model->is_placed() || !handles_are_shown_->getBool()) {
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

void InteractTool::ShowTooltip() {
  const bool is_over_view =
      panel_ && panel_->rect().contains(panel_->mapFromGlobal(QCursor::pos()));
  if (!is_over_view && !press_) models_->Hover("");  // no event tells that the mouse has left
  const WorldModel* model = models_->Find(models_->hovered());
  const bool is_wanted = is_over_view && is_active_ && panel_->window()->isActiveWindow() &&
                         !press_ && !QApplication::activePopupWidget();
  if (is_wanted && model) {
    tooltip_.Update(*model, panel_);
  } else {
    tooltip_.Hide();
  }
}

void InteractTool::TellState() {
  const ros::WallTime now = ros::WallTime::now();
  if (now - told_at_ < kStatePeriod) return;
  told_at_ = now;
  const WorldModel* model = models_->Find(models_->selected());
  if (!model || !model->is_placed()) {
    state_->setString("");
    return;
  }
  const geometry_msgs::Pose2D& pose = model->state.pose;
  const geometry_msgs::Twist& twist = model->state.twist;
  const QJsonObject state{{"name", QString::fromStdString(model->info.name)},
                          {"x", pose.x},
                          {"y", pose.y},
                          {"theta", pose.theta},
                          {"vx", twist.linear.x},
                          {"vy", twist.linear.y},
                          {"omega", twist.angular.z}};
  state_->setString(QJsonDocument(state).toJson(QJsonDocument::Compact));
}

}  // namespace flatland_viz
