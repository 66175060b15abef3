#include "wall_lines.hpp"

#include <OgreCamera.h>
#include <OgreHardwareBufferManager.h>
#include <OgreMaterialManager.h>
#include <OgrePass.h>
#include <OgreResourceGroupManager.h>
#include <OgreSceneManager.h>
#include <OgreSceneNode.h>
#include <OgreTechnique.h>
#include <OgreViewport.h>
#include <rviz/render_panel.h>

#include <algorithm>
#include <cmath>
#include <string>

namespace flatland_viz {
namespace {

constexpr float kWidest = 8.0f;  // px

/// The scale of a view from above [px/m]; 0 for other views.
float PixelsPerMetre(const rviz::RenderPanel& panel) {
  const Ogre::Camera* camera = panel.getCamera();
  if (!camera || camera->getProjectionType() != Ogre::PT_ORTHOGRAPHIC) return 0.0f;
  // The view is 2 wide in clip coordinates, in which a metre across is this long.
  const float metre = std::abs(camera->getProjectionMatrix()[0][0]);
  return metre / 2.0f * static_cast<float>(panel.getViewport()->getActualWidth());
}

}  // namespace

WallLines::WallLines(const float* ends, std::size_t count, const Ogre::MaterialPtr& material,
                     Ogre::RenderOperation::OperationType kind) {
  Ogre::VertexDeclaration& declaration = *vertices_.vertexDeclaration;
  declaration.addElement(0, 0, Ogre::VET_FLOAT2, Ogre::VES_POSITION);
  const Ogre::HardwareVertexBufferSharedPtr buffer =
      Ogre::HardwareBufferManager::getSingleton().createVertexBuffer(
          declaration.getVertexSize(0), count, Ogre::HardwareBuffer::HBU_STATIC_WRITE_ONLY);
  buffer->writeData(0, buffer->getSizeInBytes(), ends, true);
  vertices_.vertexBufferBinding->setBinding(0, buffer);
  vertices_.vertexCount = count;
  mRenderOp.vertexData = &vertices_;
  mRenderOp.operationType = kind;
  mRenderOp.useIndexes = false;
  Ogre::AxisAlignedBox box;
  for (std::size_t i = 0; i < count; ++i) {
    box.merge(Ogre::Vector3(ends[2 * i], ends[2 * i + 1], 0.0f));
  }
  setBoundingBox(box);
  setMaterial(material);
}

WallLines::~WallLines() { mRenderOp.vertexData = nullptr; }

Ogre::Real WallLines::getBoundingRadius() const {
  return Ogre::Math::boundingRadiusFromAABB(getBoundingBox());
}

Ogre::Real WallLines::getSquaredViewDepth(const Ogre::Camera* camera) const {
  const Ogre::Vector3 center = getParentNode()->_getFullTransform() * getBoundingBox().getCenter();
  return (camera->getDerivedPosition() - center).squaredLength();
}

Ogre::MaterialPtr MakeLineMaterial(const Ogre::ColourValue& color) {
  static int count = 0;
  const Ogre::MaterialPtr material = Ogre::MaterialManager::getSingleton().create(
      "flatland_viz/lines/" + std::to_string(++count),
      Ogre::ResourceGroupManager::DEFAULT_RESOURCE_GROUP_NAME);
  material->setReceiveShadows(false);
  material->setCullingMode(Ogre::CULL_NONE);  // triangles are seen from both sides
  // A self-illuminated surface without reflection has a colour independent of the light.
  material->setLightingEnabled(true);
  material->setAmbient(Ogre::ColourValue::Black);
  material->setDiffuse(Ogre::ColourValue(0.0f, 0.0f, 0.0f, color.a));
  material->setSelfIllumination(color);
  if (color.a < 0.9998f) {
    material->setSceneBlending(Ogre::SBT_TRANSPARENT_ALPHA);
    material->setDepthWriteEnabled(false);
  }
  return material;
}

LineGroup::LineGroup(const std_msgs::ColorRGBA& color, Ogre::SceneNode& parent)
    : color(color.r, color.g, color.b, color.a),
      node(parent.createChildSceneNode()),
      material(MakeLineMaterial(this->color)) {}

LineGroup::~LineGroup() {
  lines.clear();
  node->getCreator()->destroySceneNode(node);
  Ogre::MaterialManager::getSingleton().remove(material);
}

void LineGroup::Add(const float* points, std::size_t count,
                    Ogre::RenderOperation::OperationType kind) {
  lines.push_back(std::make_unique<WallLines>(points, count, material, kind));
  node->attachObject(lines.back().get());
}

void SetLineColor(Ogre::Material& material, const Ogre::ColourValue& color) {
  material.setSelfIllumination(color);
}

float LineWidth(const rviz::RenderPanel& panel, float width) {
  const float pixel = static_cast<float>(panel.devicePixelRatioF());
  return std::min(std::max(width * PixelsPerMetre(panel), pixel), kWidest * pixel);
}

void SetLineWidth(Ogre::Material& material, float width) {
  for (Ogre::Technique* technique : material.getTechniques()) {
    for (Ogre::Pass* pass : technique->getPasses()) pass->setLineWidth(width);
  }
}

}  // namespace flatland_viz
