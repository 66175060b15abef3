#pragma once

/// rviz's tool that measures distances on the floor.

#include <rviz/tool.h>

#include <QLineF>
#include <memory>

#include "world_plane.hpp"

namespace flatland_viz {

class BeforeRender;
class FlatShape;
class NameLabel;

/// A line from where the left button is pressed to where it is released, or from one click to the
/// next, with its length beside it. rviz's own tool measures between things, and does nothing on
/// the floor. The last line stays until the tool is left, or another one begun.
class MeasureTool : public rviz::Tool {
 public:
  MeasureTool();
  ~MeasureTool() override;

  void activate() override;
  void deactivate() override;
  int processMouseEvent(rviz::ViewportMouseEvent& event) override;

 protected:
  void onInitialize() override;

 private:
  enum class Phase { kBefore, kPressed, kFollowing, kDone };

  void Show(const Ogre::Viewport& viewport, double pixel_ratio);
  void Tell();

  Phase phase_ = Phase::kBefore;
  QLineF line_;                      // in the world [m]
  Ogre::SceneNode* node_ = nullptr;  // belongs to the scene
  std::unique_ptr<FlatShape> shape_;
  std::unique_ptr<NameLabel> label_;
  std::unique_ptr<BeforeRender> before_render_;
};

}  // namespace flatland_viz
