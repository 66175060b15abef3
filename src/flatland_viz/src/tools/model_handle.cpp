#include "model_handle.hpp"

#include <OgreSceneManager.h>
#include <OgreSceneNode.h>

#include <algorithm>
#include <cmath>

#include "flat_shape.hpp"
#include "screen_scale.hpp"
#include "world_models.hpp"
#include "world_plane.hpp"

namespace flatland_viz {
namespace {

constexpr float kHeight = 0.15f;  // m: above the models, below their names
constexpr double kPart = 1.4;     // of the model's radius
constexpr double kMinRadius = 20, kThin = 1.5, kStrong = 2.5, kKnob = 5.5;  // pixels
const QColor kPlain(84, 110, 140);  // of models that are no robots

}  // namespace

ModelHandle::ModelHandle(Ogre::SceneManager& scene)
    : scene_(scene),
      node_(scene.getRootSceneNode()->createChildSceneNode()),
      shape_(std::make_unique<FlatShape>(scene, *node_, 0)) {}

ModelHandle::~ModelHandle() {
  shape_.reset();
  scene_.destroySceneNode(node_);
}

double ModelHandle::Radius(const WorldModel& model, double pixel) {
  return std::max(kPart * model.radius(), kMinRadius * pixel);
}

void ModelHandle::Show(const WorldModel& model, const geometry_msgs::Pose2D& pose,
                       const WorldPlane& world, const Ogre::Viewport& viewport, double pixel_ratio,
                       bool is_strong) {
  const geometry_msgs::Pose2D middle = model.MiddleAt(pose);
  const Ogre::Vector3 at = world.PositionInScene(middle, kHeight);
  const ScreenScale scale = ScreenScale::At(at, viewport);
  const double radius = Radius(model, scale.Metres(pixel_ratio)) * scale.pixels_per_metre;
  QColor color = model.is_robot() ? model.color() : kPlain;
  color.setAlphaF(is_strong ? 0.9 : 0.5);
  if (radius != radius_ || color != color_ || is_strong != is_strong_) {
    radius_ = radius;
    color_ = color;
    is_strong_ = is_strong;
    shape_->Begin();  // in pixels
    shape_->AddRing(radius, (is_strong ? kStrong : kThin) * pixel_ratio, color);
    const Ogre::Vector2 front(static_cast<float>(radius), 0);
    if (is_strong) shape_->AddDisc(front, (kKnob + 1.5) * pixel_ratio, QColor(255, 255, 255, 230));
    shape_->AddDisc(front, (is_strong ? kKnob : kKnob - 2) * pixel_ratio, color);
    shape_->End();
  }
  shape_->Place(at, world.OrientationInScene(middle), scale.Metres(1.0));
  shape_->SetVisible(true);
}

void ModelHandle::Hide() { shape_->SetVisible(false); }

}  // namespace flatland_viz
