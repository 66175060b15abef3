#pragma once

/// Schedule of a view's drawing: on changes, but not more often than the processor can afford.

namespace flatland_viz {

/// Decides for each update of a view whether to draw it. Times are seconds of any steady clock.
///
/// A frame may take long where a program draws instead of a graphics card. Frames are then further
/// apart, so that drawing takes half of a processor core at most; except while the user moves the
/// mouse in the view or types in it.
class DrawSchedule {
 public:
  /// The scene has changed, or the drawn picture is lost.
  void Request() { is_requested_ = true; }

  /// The user moved the mouse in the view, or pressed a key.
  void UserActed(double now) { last_action_ = now; }

  /// True if the view is to be drawn now. Follow up with `Drawn` if so.
  bool IsDue(double now) const;

  /// The view was drawn.
  ///
  /// @param now  when drawing began
  /// @param cost  processor time that it took [s]
  void Drawn(double now, double cost);

 private:
  bool is_requested_ = true;
  double last_drawn_ = -1e9;
  double last_action_ = -1e9;
  double cost_ = 0.0;  // smoothed [s]
};

}  // namespace flatland_viz
