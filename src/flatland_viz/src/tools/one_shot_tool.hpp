#pragma once

/// A tool that acts once when its button or key is pressed, and takes no mouse events.

#include <rviz/tool.h>

#include <QPointer>

namespace flatland_viz {

/// Hands back to the previous tool at once. Its key acts once, however long it is held.
class OneShotTool : public rviz::Tool {
 public:
  void activate() final;
  void deactivate() final {}

  /// True while such a tool hands back: the tool activated then was only interrupted.
  static bool is_handing_over() { return is_handing_over_; }

 protected:
  void onInitialize() override;
  bool eventFilter(QObject* watched, QEvent* event) override;

 private:
  virtual void Run() = 0;

  static bool is_handing_over_;
  QPointer<rviz::Tool> previous_;
  unsigned long released_at_ = 0;  ///< X's time of the last release of its key [ms].
  bool is_first_of_toolbar_ = false;
};

}  // namespace flatland_viz
