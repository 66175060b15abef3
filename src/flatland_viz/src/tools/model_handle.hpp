#pragma once

/// The ring around a model that is turned by mouse.

#include <OgrePrerequisites.h>
#include <geometry_msgs/Pose2D.h>

#include <QColor>
#include <memory>

namespace flatland_viz {

class FlatShape;
class WorldPlane;
struct WorldModel;

class ModelHandle {
 public:
  explicit ModelHandle(Ogre::SceneManager& scene);
  ~ModelHandle();
  ModelHandle(const ModelHandle&) = delete;
  ModelHandle& operator=(const ModelHandle&) = delete;

  /// Draws it around a model.
  ///
  /// `pose`: of the model's origin; that of its last state, unless it is being dragged.
  /// `is_strong`: as for the selected model; otherwise thin, as under the mouse.
  void Show(const WorldModel& model, const geometry_msgs::Pose2D& pose, const WorldPlane& world,
            const Ogre::Viewport& viewport, double pixel_ratio, bool is_strong);
  void Hide();

  /// Its radius around a model [m]. `pixel`: the size of one of Qt's pixels there [m].
  static double Radius(const WorldModel& model, double pixel);

 private:
  Ogre::SceneManager& scene_;
  Ogre::SceneNode* node_;
  std::unique_ptr<FlatShape> shape_;
  double radius_ = 0.0;  // of the shape as it is drawn [pixels]
  QColor color_;
  bool is_strong_ = false;
};

}  // namespace flatland_viz
