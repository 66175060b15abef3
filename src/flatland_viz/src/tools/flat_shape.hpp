#pragma once

/// Coloured triangles in a plane, drawn on top of the models.

#include <OgreColourValue.h>
#include <OgreQuaternion.h>
#include <OgreVector.h>

#include <QColor>

namespace Ogre {
class ManualObject;
class SceneManager;
class SceneNode;
}  // namespace Ogre

namespace flatland_viz {

/// In its own frame: its pose and scale change without making new triangles.
class FlatShape {
 public:
  /// `layer`: shapes with a higher one are on top, from 0 to 3.
  FlatShape(Ogre::SceneManager& scene, Ogre::SceneNode& parent, int layer);
  ~FlatShape();
  FlatShape(const FlatShape&) = delete;
  FlatShape& operator=(const FlatShape&) = delete;

  /// Removes all triangles, before others are added.
  void Begin();
  void AddTriangle(const Ogre::Vector2& a, const Ogre::Vector2& b, const Ogre::Vector2& c,
                   const QColor& color);
  void AddDisc(const Ogre::Vector2& center, double radius, const QColor& color);
  void AddRing(double radius, double width, const QColor& color);
  void End();

  void Place(const Ogre::Vector3& position, const Ogre::Quaternion& orientation, double scale);
  void SetVisible(bool is_visible);

 private:
  Ogre::SceneManager& scene_;
  Ogre::SceneNode* node_;
  Ogre::ManualObject* object_;
};

/// Sets up how an object is drawn: on top of the models, in one of the layers 0 to 3.
void DrawOnTop(Ogre::ManualObject& object, int layer);

}  // namespace flatland_viz
