#pragma once

/// The names and headings of models on the map.

#include <OgrePrerequisites.h>

#include <QColor>
#include <QRectF>
#include <map>
#include <memory>
#include <string>
#include <vector>

namespace flatland_viz {

class FlatShape;
class NameLabel;
class WorldModels;
class WorldPlane;
struct WorldModel;

/// A robot has an arrow in its colour, which shows where it looks and is never smaller than can be
/// seen, and its name beside it. Other models have their names while they are selected or under the
/// mouse. Names that would cover others or models are left out.
class ModelMarks {
 public:
  struct Options {
    bool labels = true;
    bool headings = true;
    QColor background;  ///< of the view
    double pixel_ratio = 1.0;
  };

  ModelMarks(Ogre::SceneManager& scene, Ogre::SceneNode& parent);
  ~ModelMarks();

  /// Draws the models where they are now.
  void Update(const WorldModels& models, const WorldPlane& world, const Ogre::Viewport& viewport,
              const Options& options);

 private:
  struct Mark;

  /// Puts a name beside its model where it covers nothing that is taken; false if there is no such
  /// place.
  bool PlaceLabel(Mark& mark, const WorldModel& model, const WorldPlane& world,
                  const Ogre::Viewport& viewport, const Options& options,
                  std::vector<QRectF>& taken);
  void PlaceHeading(Mark& mark, const WorldModel& model, const WorldPlane& world,
                    const Ogre::Viewport& viewport, const Options& options);

  Ogre::SceneManager& scene_;
  Ogre::SceneNode& parent_;
  std::map<std::string, std::unique_ptr<Mark>> marks_;
};

}  // namespace flatland_viz
