#include "flat_shape.hpp"

#include <OgreManualObject.h>
#include <OgreMaterialManager.h>
#include <OgreRenderQueue.h>
#include <OgreResourceGroupManager.h>
#include <OgreSceneManager.h>
#include <OgreSceneNode.h>

#include <cmath>

namespace flatland_viz {
namespace {

constexpr int kSides = 72;  // of a circle

Ogre::ColourValue Colour(const QColor& color) {
  return Ogre::ColourValue(static_cast<float>(color.redF()), static_cast<float>(color.greenF()),
                           static_cast<float>(color.blueF()), static_cast<float>(color.alphaF()));
}

Ogre::Vector2 OnCircle(int side, double radius) {
  const double angle = 2 * M_PI * side / kSides;
  return {static_cast<float>(radius * std::cos(angle)),
          static_cast<float>(radius * std::sin(angle))};
}

}  // namespace

Overlay::Overlay(Ogre::SceneManager& scene, Ogre::SceneNode& parent, int layer)
    : object_(scene.createManualObject()), scene_(scene), node_(parent.createChildSceneNode()) {
  object_->setRenderQueueGroup(static_cast<Ogre::uint8>(Ogre::RENDER_QUEUE_9 + 1 + layer));
  object_->setCastShadows(false);
  object_->setDynamic(true);
  node_->attachObject(object_);
  node_->setVisible(false);
}

Overlay::~Overlay() {
  scene_.destroyManualObject(object_);
  scene_.destroySceneNode(node_);
}

Ogre::MaterialPtr Overlay::MakeMaterial(const std::string& name) {
  const Ogre::MaterialPtr material = Ogre::MaterialManager::getSingleton().create(
      name, Ogre::ResourceGroupManager::DEFAULT_RESOURCE_GROUP_NAME);
  material->setLightingEnabled(false);
  material->setDepthCheckEnabled(false);
  material->setDepthWriteEnabled(false);
  material->setCullingMode(Ogre::CULL_NONE);
  material->setSceneBlending(Ogre::SBT_TRANSPARENT_ALPHA);
  return material;
}

void FlatShape::Begin() {
  object_->clear();
  static const std::string material = MakeMaterial("flatland_viz/flat_shape")->getName();
  object_->begin(material, Ogre::RenderOperation::OT_TRIANGLE_LIST);
}

void FlatShape::AddTriangle(const Ogre::Vector2& a, const Ogre::Vector2& b, const Ogre::Vector2& c,
                            const QColor& color) {
  for (const Ogre::Vector2& corner : {a, b, c}) {
    object_->position(corner.x, corner.y, 0);
    object_->colour(Colour(color));
  }
}

void FlatShape::AddDisc(const Ogre::Vector2& center, double radius, const QColor& color) {
  for (int side = 0; side < kSides; ++side) {
    AddTriangle(center, center + OnCircle(side, radius), center + OnCircle(side + 1, radius),
                color);
  }
}

void FlatShape::AddRing(double radius, double width, const QColor& color) {
  const double inner = radius - width / 2, outer = radius + width / 2;
  for (int side = 0; side < kSides; ++side) {
    const Ogre::Vector2 a = OnCircle(side, inner), b = OnCircle(side, outer);
    const Ogre::Vector2 c = OnCircle(side + 1, inner), d = OnCircle(side + 1, outer);
    AddTriangle(a, b, c, color);
    AddTriangle(c, b, d, color);
  }
}

void FlatShape::End() { object_->end(); }

void Overlay::Place(const Ogre::Vector3& position, const Ogre::Quaternion& orientation,
                    double scale) {
  node_->setPosition(position);
  node_->setOrientation(orientation);
  const float s = static_cast<float>(scale);
  node_->setScale(s, s, 1);
}

void Overlay::SetVisible(bool is_visible) { node_->setVisible(is_visible); }

}  // namespace flatland_viz
