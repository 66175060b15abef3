/// rviz's tool that spawns models by mouse.

#include <flatland_msgs/GetModelMarkers.h>
#include <flatland_msgs/SpawnModel.h>
#include <geometry_msgs/Pose2D.h>
#include <rviz/display_context.h>
#include <rviz/render_panel.h>
#include <rviz/tool.h>
#include <rviz/tool_manager.h>
#include <rviz/view_controller.h>
#include <rviz/view_manager.h>
#include <rviz/viewport_mouse_event.h>
#include <rviz/window_manager_interface.h>
#include <visualization_msgs/MarkerArray.h>

#include <QPointer>
#include <QRegularExpression>
#include <cmath>
#include <memory>
#include <pluginlib/class_list_macros.hpp>

#include "model_preview.hpp"
#include "pause_sim_tool.hpp"
#include "screen_scale.hpp"
#include "service_caller.hpp"
#include "spawn_dialog.hpp"
#include "window_property.hpp"
#include "world_models.hpp"
#include "world_plane.hpp"

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

/// The error of a failed call; empty after success. A response's text begins with the name of an
/// exception class, which is for programs: "ModelError: there is no model".
template <class Response>
QString Failure(const QString& error, const Response& response) {
  if (!error.isEmpty() || response.success) return error;
  return QString::fromStdString(response.message).remove(QRegularExpression("^[A-Za-z_]+Error: "));
}

}  // namespace

/// First the user chooses a model in a palette. A press of the left button sets its position, a
/// drag its heading, and the server spawns it on release. If the server refuses, the menu opens
/// again with the error, and OK tries again at the same place. A right click, Escape or another
/// tool cancels all of it.
class SpawnModelTool : public rviz::Tool {
 public:
  SpawnModelTool();
  ~SpawnModelTool() override;

  void activate() override;
  void deactivate() override {}
  int processMouseEvent(rviz::ViewportMouseEvent& event) override;

 protected:
  void onInitialize() override;

 private:
  enum class Phase { kOff, kMenu, kTranslation, kRotation, kSpawning };

  void OpenMenu(const QString& error = {});
  void AskForMarkers();
  void StartPlacing(const visualization_msgs::MarkerArray& markers);
  void Follow(const rviz::ViewportMouseEvent& event);
  void Spawn();
  void End();
  void ShowHint();

  rviz::Property* spawned_;  // the name of the last model; for the window
  std::shared_ptr<WorldModels> models_;
  ServiceCaller server_;
  QPointer<SpawnDialog> dialog_;  // belongs to the window, if there is one
  std::unique_ptr<ModelPreview> preview_;
  Phase phase_ = Phase::kOff;
  geometry_msgs::Pose2D pose_;  // of the model in the world
  QString placed_file_;         // the model that the server has refused there; empty if none
};

SpawnModelTool::SpawnModelTool() : spawned_(WindowProperty("Spawned", getPropertyContainer())) {
  shortcut_key_ = 'a';
}

SpawnModelTool::~SpawnModelTool() { End(); }

void SpawnModelTool::onInitialize() {
  setCursor(Qt::CrossCursor);  // rviz's default, the icon, would cover the model
  // PauseSim interrupts this tool within one key press. So deactivate() does not end it, only
  // another tool that becomes the current one.
  connect(context_->getToolManager(), &rviz::ToolManager::toolChanged, this,
          [this](rviz::Tool* current) {
            if (current != this) End();
          });
  models_ = WorldModels::Of(*context_);
}

void SpawnModelTool::activate() {
  if (phase_ != Phase::kOff && PauseSimTool::is_handing_over()) {
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
    dialog_ = new SpawnDialog(windows ? windows->getParentWindow() : nullptr, *models_);
    connect(dialog_, &SpawnDialog::Submitted, this, &SpawnModelTool::AskForMarkers);
    connect(dialog_, &QDialog::rejected, this, &rviz::Tool::close);
  }
  dialog_->Open(error, !placed_file_.isEmpty());
  ShowHint();
}

void SpawnModelTool::AskForMarkers() {
  if (dialog_->file() == placed_file_) {
    dialog_->Wait("The server spawns the model ...");
    Spawn();
    return;
  }
  placed_file_.clear();
  preview_.reset();
  dialog_->Wait("Asking the server what the model looks like ...");
  GetModelMarkers::Request request;
  request.yaml_path = dialog_->file().toStdString();
  server_.Call<GetModelMarkers>(
      "/get_model_markers", request,
      [this](const QString& error, const GetModelMarkers::Response& response) {
        const QString failure = Failure(error, response);
        if (!failure.isEmpty()) {
          OpenMenu(failure);
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
    pose_.x = point->x();
    pose_.y = point->y();
  } else {
    const double dx = point->x() - pose_.x, dy = point->y() - pose_.y;
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
  placed_file_ = dialog_->file();
  const QString name = dialog_->name();
  SpawnModel::Request request;
  request.yaml_path = placed_file_.toStdString();
  request.name = name.toStdString();
  request.ns = dialog_->ns().toStdString();
  request.pose = pose_;
  server_.Call<SpawnModel>(
      "/spawn_model", request,
      [this, name](const QString& error, const SpawnModel::Response& response) {
        const QString failure = Failure(error, response);
        if (!failure.isEmpty()) {
          OpenMenu(failure);
          return;
        }
        dialog_->Remember();
        Announce(spawned_, name);
        Q_EMIT close();
        setStatus(QString("Spawned %1.").arg(name.toHtmlEscaped()));
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

PLUGINLIB_EXPORT_CLASS(flatland_viz::SpawnModelTool, rviz::Tool)
