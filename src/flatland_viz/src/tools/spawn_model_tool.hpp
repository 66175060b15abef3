#pragma once

/// rviz's tool that spawns models by mouse.

#include <geometry_msgs/Pose2D.h>
#include <rviz/tool.h>
#include <visualization_msgs/MarkerArray.h>

#include <QPointer>
#include <memory>

#include "model_preview.hpp"
#include "service_caller.hpp"
#include "spawn_dialog.hpp"
#include "world_plane.hpp"

namespace flatland_viz {

class WorldModels;

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

}  // namespace flatland_viz
