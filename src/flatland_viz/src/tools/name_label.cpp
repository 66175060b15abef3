#include "name_label.hpp"

#include <OgreImage.h>
#include <OgreManualObject.h>
#include <OgreMaterialManager.h>
#include <OgrePass.h>
#include <OgreTechnique.h>
#include <OgreTextureManager.h>
#include <OgreViewport.h>

#include <QApplication>
#include <QFontMetricsF>
#include <QImage>
#include <QPainter>
#include <cmath>
#include <string>

#include "screen_scale.hpp"

namespace flatland_viz {
namespace {

constexpr int kLayer = 3;
constexpr double kMarginX = 5, kMarginY = 1, kCorner = 4;  // pixels of the plate

int Even(double length) { return 2 * static_cast<int>(std::ceil(length / 2)); }

std::string UniqueName() {
  static int number = 0;
  return "flatland_viz/name_label_" + std::to_string(++number);
}

}  // namespace

NameLabel::NameLabel(Ogre::SceneManager& scene, Ogre::SceneNode& parent)
    : Overlay(scene, parent, kLayer), material_(MakeMaterial(UniqueName())) {
  Ogre::Pass& pass = *material_->getTechnique(0)->getPass(0);
  pass.setSceneBlending(Ogre::SBF_ONE, Ogre::SBF_ONE_MINUS_SOURCE_ALPHA);  // premultiplied
  Ogre::TextureUnitState& unit = *pass.createTextureUnitState();
  unit.setTextureFiltering(Ogre::TFO_NONE);
  unit.setTextureAddressingMode(Ogre::TextureUnitState::TAM_CLAMP);
}

NameLabel::~NameLabel() {
  RemoveTexture();
  Ogre::MaterialManager::getSingleton().remove(material_);
}

void NameLabel::RemoveTexture() {
  if (texture_) Ogre::TextureManager::getSingleton().remove(texture_);
  texture_.reset();
}

void NameLabel::Set(const QString& text, const LabelStyle& style) {
  if (texture_ && text == text_ && style == style_) return;
  text_ = text;
  style_ = style;
  Draw();
}

void NameLabel::Draw() {
  const double ratio = style_.pixel_ratio;
  QFont font = QApplication::font();
  font.setPointSizeF(std::max(7.5, 0.9 * font.pointSizeF()));
  const QFontMetricsF metrics(font);
  const double width = metrics.horizontalAdvance(text_) + 2 * kMarginX;
  const double height = metrics.height() + 2 * kMarginY;
  size_ = QSize(Even(ratio * width), Even(ratio * height));

  QImage image(size_, QImage::Format_ARGB32_Premultiplied);
  image.setDevicePixelRatio(ratio);
  image.fill(Qt::transparent);
  QPainter painter(&image);
  painter.setRenderHint(QPainter::Antialiasing);
  const QRectF all(0, 0, size_.width() / ratio, size_.height() / ratio);
  painter.setPen(Qt::NoPen);
  painter.setBrush(style_.plate);
  painter.drawRoundedRect(all, kCorner, kCorner);
  painter.setFont(font);
  painter.setPen(style_.text);
  painter.drawText(all, Qt::AlignCenter, text_);
  painter.end();

  RemoveTexture();
  Ogre::Image pixels;
  // Ogre only reads it; without `autoDelete` the image stays the owner.
  pixels.loadDynamicImage(image.bits(), static_cast<Ogre::uint32>(size_.width()),
                          static_cast<Ogre::uint32>(size_.height()), 1, Ogre::PF_A8R8G8B8, false);
  texture_ = Ogre::TextureManager::getSingleton().loadImage(
      UniqueName(), Ogre::ResourceGroupManager::DEFAULT_RESOURCE_GROUP_NAME, pixels,
      Ogre::TEX_TYPE_2D, 0);
  material_->getTechnique(0)->getPass(0)->getTextureUnitState(0)->setTexture(texture_);

  object_->clear();
  object_->begin(material_->getName(), Ogre::RenderOperation::OT_TRIANGLE_STRIP);
  const float x = 0.5f * static_cast<float>(size_.width());
  const float y = 0.5f * static_cast<float>(size_.height());
  object_->position(-x, y, 0);
  object_->textureCoord(0, 0);
  object_->position(-x, -y, 0);
  object_->textureCoord(0, 1);
  object_->position(x, y, 0);
  object_->textureCoord(1, 0);
  object_->position(x, -y, 0);
  object_->textureCoord(1, 1);
  object_->end();
}

void NameLabel::Place(const Ogre::Vector3& position, const Ogre::Viewport& viewport) {
  const ScreenScale scale = ScreenScale::At(position, viewport);
  Overlay::Place(OnPixels(position, viewport), scale.camera, scale.Metres(1.0));
}

}  // namespace flatland_viz
