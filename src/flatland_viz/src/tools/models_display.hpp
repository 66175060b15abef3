#pragma once

/// rviz's display of the models' names and headings.

#include <OgrePrerequisites.h>
#include <ros/time.h>
#include <rviz/display.h>

#include <QColor>
#include <memory>

namespace flatland_viz {

class BeforeRender;
class GroundTruthFrames;
class ModelMarks;
class WorldModels;

/// Names the models, shows where robots look, and places robots by their ground truth where there
/// is no localiser.
class ModelsDisplay : public rviz::Display {
  Q_OBJECT

 public:
  ModelsDisplay();
  ~ModelsDisplay() override;

  void update(float wall_dt, float ros_dt) override;
  void reset() override;

 protected:
  void onInitialize() override;
  void onEnable() override;
  void onDisable() override;

 private:
  void PlaceFrames();
  void PlaceMarks(const Ogre::Viewport& viewport, double pixel_ratio);
  void ListColors();
  void FollowBounds();
  QColor Background() const;

  rviz::BoolProperty* labels_;
  rviz::BoolProperty* headings_;
  rviz::BoolProperty* places_frames_;
  rviz::Property* colors_;         // of the robots, "#rrggbb" by name
  rviz::Property* bounds_;         // around all models [m]; null while some are not placed
  rviz::Property* placed_frames_;  // by ground truth, with commas between them

  std::shared_ptr<WorldModels> models_;
  std::unique_ptr<GroundTruthFrames> frames_;
  std::unique_ptr<ModelMarks> marks_;
  std::unique_ptr<BeforeRender> before_render_;
  unsigned drawn_revision_ = 0;  // of the models
  unsigned bounds_revision_ = 0;
  ros::WallTime bounds_at_;
};

}  // namespace flatland_viz
