#pragma once

/// Lines of a width in pixels, or triangles, in one static vertex buffer.

#include <OgreMaterial.h>
#include <OgreSimpleRenderable.h>
#include <std_msgs/ColorRGBA.h>

#include <cstddef>
#include <memory>
#include <vector>

namespace rviz {
class RenderPanel;
}  // namespace rviz

namespace flatland_viz {

/// Lines on the ground that are made once. A line takes 16 bytes; rviz's own take hundreds, and are
/// computed again when the camera moves.
class WallLines : public Ogre::SimpleRenderable {
 public:
  /// @param ends  x, y of both ends of each line, or of the corners of triangles [m]; may be
  /// discarded afterwards
  /// @param count  number of ends or corners, at least 2
  /// @param material  has the colour, and the lines' width
  /// @param kind  OT_LINE_LIST or OT_TRIANGLE_LIST
  WallLines(const float* ends, std::size_t count, const Ogre::MaterialPtr& material,
            Ogre::RenderOperation::OperationType kind = Ogre::RenderOperation::OT_LINE_LIST);
  ~WallLines() override;

  Ogre::Real getBoundingRadius() const override;
  Ogre::Real getSquaredViewDepth(const Ogre::Camera* camera) const override;

 private:
  Ogre::VertexData vertices_;
};

/// A material of one colour, whatever the light, for `WallLines`. Remove it from the
/// MaterialManager.
Ogre::MaterialPtr MakeLineMaterial(const Ogre::ColourValue& color);

/// Sets the colour of all lines with such a material, but not how transparent they are.
void SetLineColor(Ogre::Material& material, const Ogre::ColourValue& color);

/// Lines and triangles of one colour, with a node of their own.
struct LineGroup {
  LineGroup(const std_msgs::ColorRGBA& color, Ogre::SceneNode& parent);
  ~LineGroup();
  LineGroup(const LineGroup&) = delete;
  LineGroup& operator=(const LineGroup&) = delete;

  void Add(const float* points, std::size_t count, Ogre::RenderOperation::OperationType kind);

  Ogre::ColourValue color;
  Ogre::SceneNode* node;
  Ogre::MaterialPtr material;
  std::vector<std::unique_ptr<WallLines>> lines;
};

/// The width of lines in a view [px]: so many metres, but at least a pixel, and never huge.
float LineWidth(const rviz::RenderPanel& panel, float width);

/// Sets the width of all lines with a material [px].
void SetLineWidth(Ogre::Material& material, float width);

}  // namespace flatland_viz
