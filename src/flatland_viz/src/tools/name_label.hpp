#pragma once

/// A name on a plate of constant size on the screen.

#include <OgreMaterial.h>
#include <OgreTexture.h>
#include <OgreVector.h>

#include <QColor>
#include <QSize>
#include <QString>

namespace Ogre {
class ManualObject;
class SceneManager;
class SceneNode;
class Viewport;
}  // namespace Ogre

namespace flatland_viz {

/// The appearance of a label.
struct LabelStyle {
  QColor text;
  QColor plate;
  double pixel_ratio = 1.0;  ///< device pixels per device-independent pixel (Qt)

  bool operator==(const LabelStyle& other) const {
    return text == other.text && plate == other.plate && pixel_ratio == other.pixel_ratio;
  }
};

class NameLabel {
 public:
  NameLabel(Ogre::SceneManager& scene, Ogre::SceneNode& parent);
  ~NameLabel();
  NameLabel(const NameLabel&) = delete;
  NameLabel& operator=(const NameLabel&) = delete;

  /// Draws the label again if it has changed.
  void Set(const QString& text, const LabelStyle& style);
  /// [device pixels]
  QSize size() const { return size_; }
  /// Puts its middle there.
  void Place(const Ogre::Vector3& position, const Ogre::Viewport& viewport);
  void SetVisible(bool is_visible);

 private:
  void Draw();
  void RemoveTexture();

  Ogre::SceneManager& scene_;
  Ogre::SceneNode* node_;
  Ogre::ManualObject* object_;
  Ogre::MaterialPtr material_;
  Ogre::TexturePtr texture_;
  QString text_;
  LabelStyle style_;
  QSize size_;
};

}  // namespace flatland_viz
