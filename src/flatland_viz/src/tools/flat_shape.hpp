#pragma once

/// Coloured triangles in a plane, drawn on top of the models.

#include <OgreMaterial.h>
#include <OgreQuaternion.h>
#include <OgreVector.h>

#include <QColor>
#include <string>

namespace flatland_viz {

/// Something flat that is drawn on top of the models, in its own frame: its pose and scale change
/// without making new triangles. Hidden at first.
class Overlay {
 public:
  /// `layer`: those with a higher one are on top, from 0 to 3.
  Overlay(Ogre::SceneManager& scene, Ogre::SceneNode& parent, int layer);
  ~Overlay();
  Overlay(const Overlay&) = delete;
  Overlay& operator=(const Overlay&) = delete;

  void Place(const Ogre::Vector3& position, const Ogre::Quaternion& orientation, double scale);
  void SetVisible(bool is_visible);

 protected:
  /// A material that no light and nothing in front changes.
  static Ogre::MaterialPtr MakeMaterial(const std::string& name);

  Ogre::ManualObject* object_;

 private:
  Ogre::SceneManager& scene_;
  Ogre::SceneNode* node_;
};

class FlatShape : public Overlay {
 public:
  using Overlay::Overlay;

  /// Removes all triangles, before others are added.
  void Begin();
  void AddTriangle(const Ogre::Vector2& a, const Ogre::Vector2& b, const Ogre::Vector2& c,
                   const QColor& color);
  void AddDisc(const Ogre::Vector2& center, double radius, const QColor& color);
  void AddRing(double radius, double width, const QColor& color);
  void End();
};

}  // namespace flatland_viz
