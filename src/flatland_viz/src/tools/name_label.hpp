#pragma once

/// A name on a plate of constant size on the screen.

#include <OgreTexture.h>

#include <QSize>
#include <QString>

#include "flat_shape.hpp"

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

class NameLabel : public Overlay {
 public:
  NameLabel(Ogre::SceneManager& scene, Ogre::SceneNode& parent);
  ~NameLabel();

  /// Draws the label again if it has changed.
  void Set(const QString& text, const LabelStyle& style);
  /// [device pixels]
  QSize size() const { return size_; }
  /// Puts its middle there.
  void Place(const Ogre::Vector3& position, const Ogre::Viewport& viewport);

 private:
  void Draw();
  void RemoveTexture();

  Ogre::MaterialPtr material_;
  Ogre::TexturePtr texture_;
  QString text_;
  LabelStyle style_;
  QSize size_;
};

}  // namespace flatland_viz
