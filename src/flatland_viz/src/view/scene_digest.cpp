#include "scene_digest.hpp"

#include <OgreBillboardChain.h>
#include <OgreCamera.h>
#include <OgreMaterial.h>
#include <OgrePass.h>
#include <OgreRenderOperation.h>
#include <OgreRenderWindow.h>
#include <OgreRenderable.h>
#include <OgreSceneManager.h>
#include <OgreSceneNode.h>
#include <OgreTechnique.h>
#include <OgreTextureUnitState.h>
#include <OgreViewport.h>
#include <rviz/ogre_helpers/movable_text.h>

#include <functional>
#include <string>
#include <string_view>
#include <type_traits>

namespace flatland_viz {
namespace {

constexpr std::size_t kSamples = 256;  // elements of an object with lines that are read, at most

/// A running hash: of each value xor, multiply by a large odd number, mix high bits into low.
class Hash {
 public:
  template <typename T>
  void Add(const T& value) {
    static_assert(std::is_trivially_copyable<T>::value, "its bytes are hashed");
    AddBytes(&value, sizeof value);
  }

  void Add(const std::string& text) { AddBytes(text.data(), text.size()); }
  void Add(const Ogre::Vector3& v) { AddBytes(v.ptr(), 3 * sizeof(Ogre::Real)); }
  void Add(const Ogre::ColourValue& c) { AddBytes(c.ptr(), 4 * sizeof(float)); }
  void Add(const Ogre::Affine3& m) { AddBytes(m[0], 12 * sizeof(Ogre::Real)); }
  void Add(const Ogre::Matrix4& m) { AddBytes(m[0], 16 * sizeof(Ogre::Real)); }
  void Add(const Ogre::AxisAlignedBox& box) {
    Add(box.isFinite());
    if (!box.isFinite()) return;
    Add(box.getMinimum());
    Add(box.getMaximum());
  }

  std::uint64_t value() const { return value_; }

 private:
  void AddBytes(const void* data, std::size_t size) {
    const std::string_view bytes(static_cast<const char*>(data), size);
    value_ = (value_ ^ std::hash<std::string_view>()(bytes)) * 0x9E3779B97F4A7C15u;
    value_ ^= value_ >> 29;
  }

  std::uint64_t value_ = 0xCBF29CE484222325u;
};

void AddMaterial(Hash& hash, const Ogre::Material& material) {
  hash.Add(&material);
  for (const Ogre::Technique* technique : material.getTechniques()) {
    for (const Ogre::Pass* pass : technique->getPasses()) {
      hash.Add(pass->getAmbient());
      hash.Add(pass->getDiffuse());
      hash.Add(pass->getSelfIllumination());
      hash.Add(pass->getPointSize());
      hash.Add(pass->getLineWidth());
      for (const Ogre::TextureUnitState* unit : pass->getTextureUnitStates()) {
        hash.Add(unit->_getTexturePtr().get());
      }
    }
  }
}

void AddGeometry(Hash& hash, Ogre::Renderable& renderable) {
  Ogre::RenderOperation operation;
  renderable.getRenderOperation(operation);
  if (const Ogre::VertexData* vertices = operation.vertexData) {
    hash.Add(vertices->vertexStart);
    hash.Add(vertices->vertexCount);
    for (const auto& binding : vertices->vertexBufferBinding->getBindings()) {
      hash.Add(binding.second.get());
    }
  }
  if (const Ogre::IndexData* indices = operation.indexData) {
    hash.Add(indices->indexCount);
    hash.Add(indices->indexBuffer.get());
  }
}

class RenderableHasher : public Ogre::Renderable::Visitor {
 public:
  explicit RenderableHasher(Hash& hash) : hash_(hash) {}

  void visit(Ogre::Renderable* renderable, Ogre::ushort, bool, Ogre::Any*) override {
    hash_.Add(renderable);
    if (const Ogre::MaterialPtr& material = renderable->getMaterial()) {
      AddMaterial(hash_, *material);
    }
    AddGeometry(hash_, *renderable);
  }

 private:
  Hash& hash_;
};

void AddLines(Hash& hash, const Ogre::BillboardChain& lines) {
  const std::size_t chains = lines.getNumberOfChains();
  hash.Add(chains);
  if (const Ogre::MaterialPtr& material = lines.getMaterial()) AddMaterial(hash, *material);
  const std::size_t step = chains / kSamples + 1;
  std::size_t read = 0;
  for (std::size_t chain = 0; chain < chains; chain += step) {
    const std::size_t elements = lines.getNumChainElements(chain);
    hash.Add(elements);
    for (std::size_t i = 0; i < elements && read < kSamples; ++i, ++read) {
      const Ogre::BillboardChain::Element& element = lines.getChainElement(chain, i);
      hash.Add(element.position);
      hash.Add(element.width);
      hash.Add(element.colour);
    }
  }
}

void AddObject(Hash& hash, Ogre::MovableObject& object) {
  hash.Add(object.isVisible());
  if (!object.isVisible()) return;
  hash.Add(&object);
  hash.Add(object.getRenderQueueGroup());
  hash.Add(object.getBoundingBox());
  if (const auto* lines = dynamic_cast<const Ogre::BillboardChain*>(&object)) {
    AddLines(hash, *lines);
    return;
  }
  if (const auto* text = dynamic_cast<const rviz::MovableText*>(&object)) {
    hash.Add(text->getCaption());
    hash.Add(text->getColor());
    return;  // its buffers are made when it is drawn
  }
  RenderableHasher hasher(hash);
  object.visitRenderables(&hasher);
}

void AddNode(Hash& hash, const Ogre::SceneNode& node) {
  const auto& objects = node.getAttachedObjects();
  if (!objects.empty()) hash.Add(node._getFullTransform());
  for (Ogre::MovableObject* object : objects) AddObject(hash, *object);
  for (const Ogre::Node* child : node.getChildren()) {
    AddNode(hash, *static_cast<const Ogre::SceneNode*>(child));
  }
}

void AddViewport(Hash& hash, const Ogre::Viewport& viewport) {
  hash.Add(viewport.getActualWidth());
  hash.Add(viewport.getActualHeight());
  hash.Add(viewport.getBackgroundColour());
  hash.Add(viewport.getVisibilityMask());
  const Ogre::Camera* camera = viewport.getCamera();
  if (!camera) return;
  hash.Add(camera->getViewMatrix());
  hash.Add(camera->getProjectionMatrix());
  AddNode(hash, *camera->getSceneManager()->getRootSceneNode());
}

}  // namespace

std::uint64_t DigestOfScene(const Ogre::RenderWindow& window) {
  Hash hash;
  for (unsigned short i = 0; i < window.getNumViewports(); ++i) {
    AddViewport(hash, *const_cast<Ogre::RenderWindow&>(window).getViewport(i));
  }
  return hash.value();
}

}  // namespace flatland_viz
