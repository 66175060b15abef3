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

namespace flatland_viz {

class BeforeRender;
class WorldModels;

/// A click selects a model, a drag moves it, a drag of its ring turns it; all else goes to the
/// view.
///
/// Its properties connect it with the window's panels: "Selected" is the name of the selected
/// model, "State" its pose and velocity, "Dragged" the model that was dragged last, "Menu" that of
/// which the user asks for the context menu. All but "Selected" are for reading.
class InteractTool : public rviz::Tool {
  Q_OBJECT

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

}  // namespace flatland_viz
