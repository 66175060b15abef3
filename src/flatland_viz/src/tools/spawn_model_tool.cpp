#include "spawn_model_tool.hpp"

#include <flatland_msgs/GetModelMarkers.h>
#include <flatland_msgs/SpawnModel.h>
#include <rviz/display_context.h>
#include <rviz/render_panel.h>
#include <rviz/tool_manager.h>
#include <rviz/view_controller.h>
#include <rviz/view_manager.h>
#include <rviz/viewport_mouse_event.h>
#include <rviz/window_manager_interface.h>

#include <cmath>

#include "error_text.hpp"
#include "one_shot_tool.hpp"
#include "screen_scale.hpp"

namespace flatland_viz {
namespace {

using flatland_msgs::GetModelMarkers;
using flatland_msgs::SpawnModel;

constexpr double kMinDistance = 6;  // pixels: a nearer cursor gives no direction

bool IsPress(const rviz::ViewportMouseEvent& event, Qt::MouseButton button) {
  // The second of two quick clicks arrives as a double click.
  return event.acting_button == button &&
         (event.type == QEvent::MouseButtonPress || event.type == QEvent::MouseButtonDblClick);
}

bool IsForTheView(const rviz::ViewportMouseEvent& event) {
  return event.type == QEvent::Wheel || event.acting_button == Qt::MiddleButton ||
         (event.buttons_down & Qt::MiddleButton);
}

}  // namespace

SpawnModelTool::SpawnModelTool() : properties_(getPropertyContainer()) { shortcut_key_ = 'a'; }

SpawnModelTool::~SpawnModelTool() { End(); }

void SpawnModelTool::onInitialize() {
  setCursor(Qt::CrossCursor);  // rviz's default, the icon, would cover the model
  // A OneShotTool such as PauseSim interrupts this tool within one key press. So deactivate() does
  // not end it, only another tool that becomes the current one.
  connect(context_->getToolManager(), &rviz::ToolManager::toolChanged, this,
          [this](rviz::Tool* current) {
            if (current != this) End();
          });
  ros::NodeHandle node;
  node.setCallbackQueue(context_->getUpdateQueue());
  models_ = node.subscribe<flatland_msgs::ModelList>(
      "/flatland_server/models", 1, [this](const flatland_msgs::ModelList::ConstPtr& models) {
        names_ = WorldNames(*models);
        files_.Add(*models);
        if (dialog_) dialog_->SetNames(names_);
      });
}

void SpawnModelTool::activate() {
  if (phase_ != Phase::kOff && OneShotTool::is_handing_over()) {
    ShowHint();
  } else {
    End();
    OpenMenu();
  }
}

void SpawnModelTool::OpenMenu(const QString& error) {
  phase_ = Phase::kMenu;
  if (!dialog_) {
    rviz::WindowManagerInterface* windows = context_->getWindowManager();
    dialog_ =
        new SpawnDialog(windows ? windows->getParentWindow() : nullptr, properties_.Read(), files_);
    dialog_->SetNames(names_);
    files_.Look();
    connect(dialog_, &SpawnDialog::Submitted, this, &SpawnModelTool::AskForMarkers);
    connect(dialog_, &QDialog::rejected, this, &rviz::Tool::close);
  }
  dialog_->Open(error, !placed_file_.isEmpty());
  ShowHint();
}

void SpawnModelTool::AskForMarkers(const ModelChoice& choice) {
  properties_.Write(choice);
  choice_ = choice;
  if (choice.file == placed_file_) {
    dialog_->Wait("The server spawns the model ...");
    Spawn();
    return;
  }
  placed_file_.clear();
  preview_.reset();
  dialog_->Wait("Asking the server what the model looks like ...");
  GetModelMarkers::Request request;
  request.yaml_path = choice.file.toStdString();
  server_.Call<GetModelMarkers>(
      "/get_model_markers", request,
      [this](const QString& error, const GetModelMarkers::Response& response) {
        if (!error.isEmpty()) {
          OpenMenu(error);
        } else if (!response.success) {
          OpenMenu(QString::fromStdString(ErrorText(response.message)));
        } else if (!WorldPlane::Find(*context_)) {
          OpenMenu(QString("There is no transform from the world's frame \"%1\" to rviz's fixed "
                           "frame \"%2\". Choose \"%1\" as the fixed frame.")
                       .arg(WorldPlane::kFrame, context_->getFixedFrame()));
        } else {
          StartPlacing(response.markers);
        }
      });
}

void SpawnModelTool::StartPlacing(const visualization_msgs::MarkerArray& markers) {
  dialog_->hide();
  preview_ = std::make_unique<ModelPreview>(*context_, markers);
  pose_ = geometry_msgs::Pose2D();
  phase_ = Phase::kTranslation;
  rviz::RenderPanel* panel = context_->getViewManager()->getRenderPanel();
  panel->activateWindow();
  panel->setFocus();  // for Escape
  ShowHint();
}

int SpawnModelTool::processMouseEvent(rviz::ViewportMouseEvent& event) {
  if (phase_ == Phase::kOff || phase_ == Phase::kMenu) return 0;
  ShowHint();
  if (IsForTheView(event)) {
    context_->getViewManager()->getCurrent()->handleMouseEvent(event);
    return 0;
  }
  if (IsPress(event, Qt::RightButton)) return Finished;
  if (phase_ == Phase::kSpawning) return 0;

  Follow(event);
  if (phase_ == Phase::kTranslation && IsPress(event, Qt::LeftButton)) {
    phase_ = Phase::kRotation;
    ShowHint();
  } else if (phase_ == Phase::kRotation && event.leftUp()) {
    Spawn();
  }
  return Render;
}

void SpawnModelTool::Follow(const rviz::ViewportMouseEvent& event) {
  const auto world = WorldPlane::Find(*context_);
  if (!world) return;
  const auto point = world->PointAt(event.viewport, event.x, event.y);
  if (!point) return;
  if (phase_ == Phase::kTranslation) {
    pose_.x = point->x;
    pose_.y = point->y;
  } else {
    const double dx = point->x - pose_.x, dy = point->y - pose_.y;
    const double scale =
        ScreenScale::At(world->PositionInScene(pose_, 0), *event.viewport).pixels_per_metre;
    const double least = kMinDistance * event.panel->devicePixelRatioF() / scale;
    if (std::hypot(dx, dy) > least) pose_.theta = std::atan2(dy, dx);
  }
  preview_->Place(pose_, *world);
}

void SpawnModelTool::Spawn() {
  phase_ = Phase::kSpawning;
  ShowHint();
  const ModelChoice choice = choice_;
  placed_file_ = choice.file;
  SpawnModel::Request request;
  request.yaml_path = choice.file.toStdString();
  request.name = choice.Name().toStdString();
  request.ns = choice.Namespace().toStdString();
  request.pose = pose_;
  server_.Call<SpawnModel>(
      "/spawn_model", request,
      [this, choice](const QString& error, const SpawnModel::Response& response) {
        if (!error.isEmpty()) {
          OpenMenu(error);
        } else if (!response.success) {
          OpenMenu(QString::fromStdString(ErrorText(response.message)));
        } else {
          ModelChoice next = choice;
          if (choice.is_numbered) {
            ++next.number;
          } else {
            next.own_name.clear();  // both are taken now
            next.own_ns.clear();
          }
          properties_.Write(next);
          files_.AddRecent(choice.file);
          properties_.Announce(choice.Name());
          Q_EMIT close();
          setStatus(QString("Spawned %1.").arg(choice.Name().toHtmlEscaped()));
        }
      });
}

void SpawnModelTool::End() {
  if (phase_ != Phase::kOff) setStatus("");  // the hint would stay
  phase_ = Phase::kOff;
  server_.Cancel();
  placed_file_.clear();
  preview_.reset();
  if (!dialog_) return;
  dialog_->hide();
  dialog_->deleteLater();  // its own Cancel button may have led here
  dialog_.clear();
}

void SpawnModelTool::ShowHint() {
  const QString cancel = " <b>Right-Click/Esc:</b> Cancel.";
  switch (phase_) {
    case Phase::kOff:
      break;
    case Phase::kMenu:
      setStatus("Choose the model to spawn." + cancel);
      break;
    case Phase::kTranslation:
      setStatus("<b>Click:</b> Spawn the model here. <b>Press and drag:</b> Turn it, too." +
                cancel);
      break;
    case Phase::kRotation:
      setStatus("<b>Drag:</b> Turn the model. <b>Release:</b> Spawn it." + cancel);
      break;
    case Phase::kSpawning:
      setStatus("The server spawns the model ...");
      break;
  }
}

}  // namespace flatland_viz
