#pragma once

/// rviz's view from above, with the mouse of maps.

#include <ros/time.h>
#include <rviz/default_plugin/view_controllers/fixed_orientation_ortho_view_controller.h>

#include <QPointF>
#include <memory>
#include <optional>
#include <string>

namespace rviz {
class StringProperty;
}

namespace flatland_viz {

class WorldModels;

/// A drag with the left or middle button pans, the wheel zooms at the cursor, and a drag with Ctrl
/// rotates about the middle. It has the properties of rviz's TopDownOrtho, and "Follow", the name
/// of a model that the view moves along with, except while the mouse drags it.
class MapView : public rviz::FixedOrientationOrthoViewController {
  Q_OBJECT

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

}  // namespace flatland_viz
