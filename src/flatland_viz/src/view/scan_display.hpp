#pragma once

/// An rviz display for laser scans.

#include <OgreMaterial.h>
#include <rviz/message_filter_display.h>
#include <sensor_msgs/LaserScan.h>

#include <memory>
#include <vector>

namespace rviz {
class ColorProperty;
}  // namespace rviz

namespace flatland_viz {

class WallLines;

/// Shows the last scan as points in one colour, at a fraction of the cost of rviz's display, which
/// makes a cloud of each scan. The scan stays when simulated time goes back, until the next one.
class ScanDisplay : public rviz::MessageFilterDisplay<sensor_msgs::LaserScan> {
  Q_OBJECT

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

}  // namespace flatland_viz
