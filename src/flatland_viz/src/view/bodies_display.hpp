#pragma once

/// An rviz display for the bodies of models.

#include <rviz/default_plugin/marker_display.h>

namespace flatland_viz {

/// Shows a MarkerArray, as rviz's own display does, but without a gap when simulated time goes
/// back: rviz then discards all messages. This display subscribes again, and keeps the former
/// markers until the server's answer replaces all of them in one frame.
class BodiesDisplay : public rviz::MarkerDisplay {
  Q_OBJECT

 public:
  void reset() override;

 protected:
  void onDisable() override;
  void subscribe() override;
  void unsubscribe() override;

 private:
  void Receive(const visualization_msgs::MarkerArray::ConstPtr& markers);

  bool is_of_former_run_ = false;  // what is shown
};

}  // namespace flatland_viz
