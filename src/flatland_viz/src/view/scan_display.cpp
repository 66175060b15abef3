/// An rviz display for laser scans.

#include <OgreMaterial.h>
#include <OgreMaterialManager.h>
#include <OgreSceneNode.h>
#include <rviz/message_filter_display.h>
#include <rviz/properties/color_property.h>
#include <rviz/render_panel.h>
#include <rviz/view_manager.h>
#include <sensor_msgs/LaserScan.h>

#include <cmath>
#include <memory>
#include <pluginlib/class_list_macros.hpp>
#include <utility>
#include <vector>

#include "wall_lines.hpp"

namespace flatland_viz {
namespace {

constexpr double kPointSize = 3.0;  // px
constexpr float kHeight = 0.005f;   // m above the lidar: over walls, below bodies

}  // namespace

/// Shows the last scan as points in one colour, at a fraction of the cost of rviz's display, which
/// makes a cloud of each scan. The scan stays when simulated time goes back, until the next one.
class ScanDisplay : public rviz::MessageFilterDisplay<sensor_msgs::LaserScan> {
 public:
  ScanDisplay();
  ~ScanDisplay() override;

  void update(float wall_dt, float ros_dt) override;

 protected:
  void onInitialize() override;
  void onDisable() override;
  void processMessage(const sensor_msgs::LaserScan::ConstPtr& scan) override;

 private:
  rviz::ColorProperty* color_;
  Ogre::MaterialPtr material_;
  std::unique_ptr<WallLines> points_;
};

ScanDisplay::ScanDisplay()
    : color_(new rviz::ColorProperty("Color", QColor(213, 94, 0), "Colour of the points.", this)) {}

ScanDisplay::~ScanDisplay() {
  points_.reset();
  if (material_) Ogre::MaterialManager::getSingleton().remove(material_);
}

void ScanDisplay::onInitialize() {
  MFDClass::onInitialize();
  material_ = MakeLineMaterial(Ogre::ColourValue::White);
  const double ratio = context_->getViewManager()->getRenderPanel()->devicePixelRatioF();
  material_->setPointSize(static_cast<Ogre::Real>(kPointSize * ratio));
}

void ScanDisplay::onDisable() {
  MFDClass::onDisable();
  points_.reset();
}

void ScanDisplay::processMessage(const sensor_msgs::LaserScan::ConstPtr& scan) {
  Ogre::Vector3 position;
  Ogre::Quaternion orientation;
  if (!context_->getFrameManager()->getTransform(scan->header, position, orientation)) return;
  std::vector<float> ends;
  float angle = scan->angle_min;
  for (const float range : scan->ranges) {
    if (range >= scan->range_min && range < scan->range_max) {
      ends.insert(ends.end(), {range * std::cos(angle), range * std::sin(angle)});
    }
    angle += scan->angle_increment;
  }
  // The former points are deleted after the new ones are made: RenderOnChange tells them apart by
  // address.
  const std::unique_ptr<WallLines> former = std::move(points_);
  if (ends.empty()) return;
  points_ = std::make_unique<WallLines>(ends.data(), ends.size() / 2, material_,
                                        Ogre::RenderOperation::OT_POINT_LIST);
  getSceneNode()->setPosition(position + orientation * Ogre::Vector3(0.0f, 0.0f, kHeight));
  getSceneNode()->setOrientation(orientation);
  getSceneNode()->attachObject(points_.get());
}

void ScanDisplay::update(float, float) { SetLineColor(*material_, color_->getOgreColor()); }

}  // namespace flatland_viz

PLUGINLIB_EXPORT_CLASS(flatland_viz::ScanDisplay, rviz::Display)
