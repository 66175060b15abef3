#pragma once

/// An rviz display for the bodies of models.

#include <rviz/default_plugin/marker_array_display.h>

namespace flatland_viz {

/// rviz's MarkerArray, without a gap when simulated time goes back: rviz then discards all markers,
/// and has none until they are sent again. The server replaces all of them by one message.
class BodiesDisplay : public rviz::MarkerArrayDisplay {
  Q_OBJECT

 public:
  void reset() override { rviz::Display::reset(); }
};

}  // namespace flatland_viz
