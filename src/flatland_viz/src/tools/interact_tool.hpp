#pragma once

/// The default tool: looking around, selecting, dragging and turning models.

#include <ros/time.h>
#include <rviz/tool.h>

#include <QPointF>
#include <memory>
#include <optional>
#include <string>

#include "model_drag.hpp"
#include "model_handle.hpp"
#include "model_tooltip.hpp"

namespace Ogre {
class Viewport;
}

namespace rviz {
class BoolProperty;
class RenderPanel;
class StringProperty;
}  // namespace rviz

namespace flatland_viz {

class BeforeRender;
class WorldModels;
struct WorldModel;

/// A click selects a model, a drag moves it, a drag of its ring turns it; all else goes to the
/// view.
///
/// Its hidden properties connect it with the window's panels: "Selected" is the name of the
/// selected model, "State" its pose and velocity, "Dragged" the model that was dragged last, "Menu"
/// that of which the user asks for the context menu. All but "Selected" are for reading.
class InteractTool : public rviz::Tool {
  Q_OBJECT

 public:
  InteractTool();
  ~InteractTool() override;

  void activate() override;
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

  Hit FindHit(const QPointF& at, double pixels_per_metre, double pixel_ratio) const;
  /// The model that the mouse has reached or not left yet, with its ring.
  void FollowHover(const Hit& hit, const QPointF& at, double pixels_per_metre, double pixel_ratio);
  /// Looks again for the model under the mouse: models move while it rests.
  void LookUnderMouse();
  int Release(rviz::ViewportMouseEvent& event);
  void BeginDrag(const QPointF& at);
  void EndDrag();
  void PassOn(rviz::ViewportMouseEvent& event);
  void ShowHint(const Hit& hit);
  void ShowHandles(const Ogre::Viewport& viewport, double pixel_ratio);
  void ShowTooltip();
  void TellState();

  rviz::BoolProperty* handles_are_shown_;
  rviz::StringProperty* selected_;
  rviz::StringProperty* state_;
  rviz::StringProperty* dragged_;
  rviz::StringProperty* menu_;

  std::shared_ptr<WorldModels> models_;
  std::unique_ptr<ModelHandle> hovered_handle_, selected_handle_;
  std::unique_ptr<BeforeRender> before_render_;
  ModelDrag drag_;
  Part dragged_part_ = Part::kNone;
  QPointF turn_middle_;  // of the model that is being turned, in the world [m]
  std::optional<Press> press_;
  bool is_panning_ = false;  // the view has the mouse until the button is released
  bool is_active_ = false;
  rviz::RenderPanel* panel_ = nullptr;  // with the mouse; known after the first event
  ModelTooltip tooltip_;
  ros::WallTime told_at_, looked_at_;
  unsigned looked_revision_ = 0;  // of the models
};

}  // namespace flatland_viz
