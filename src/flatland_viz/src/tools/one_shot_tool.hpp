#pragma once

/// A tool that does something when its button or key is pressed, and takes no mouse.

#include <rviz/tool.h>

#include <QPointer>

namespace flatland_viz {

/// Hands over to the tool that was the current one before, at once.
class OneShotTool : public rviz::Tool {
 public:
  void activate() final;
  void deactivate() final {}

  /// True while such a tool hands over: then the tool that is activated has only been interrupted.
  static bool is_handing_over() { return is_handing_over_; }

 protected:
  void onInitialize() override;

 private:
  virtual void Run() = 0;

  static bool is_handing_over_;
  QPointer<rviz::Tool> previous_;
  bool is_first_of_toolbar_ = false;
};

}  // namespace flatland_viz
