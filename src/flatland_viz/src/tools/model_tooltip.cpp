#include "model_tooltip.hpp"

#include <QApplication>
#include <QCursor>
#include <QToolTip>
#include <QWindow>
#include <cmath>

#include "world_models.hpp"

namespace flatland_viz {
namespace {

const ros::WallDuration kTooltipDelay(0.4), kTooltipPeriod(0.2);

/// A number without "-0.00".
QString Fixed(double value, int digits) {
  const double unit = std::pow(10.0, -digits);
  return QString::number(std::abs(value) < unit / 2 ? 0.0 : value, 'f', digits);
}

QString TooltipText(const WorldModel& model) {
  const geometry_msgs::Pose2D& pose = model.state.pose;
  const geometry_msgs::Twist& twist = model.state.twist;
  return QString(
             "<p style='white-space:pre'><b>%1</b><br>x %2 m   y %3 m   %4°<br>%5 m/s   %6 rad/s")
      .arg(QString::fromStdString(model.info.name).toHtmlEscaped(), Fixed(pose.x, 2),
           Fixed(pose.y, 2), Fixed(std::remainder(pose.theta, 2 * M_PI) * 180 / M_PI, 0),
           Fixed(std::hypot(twist.linear.x, twist.linear.y), 2), Fixed(twist.angular.z, 2));
}

}  // namespace

void ModelTooltip::Restart() {
  hovered_since_ = ros::WallTime::now();
  Hide();
}

void ModelTooltip::Hide() {
  if (is_shown_) QToolTip::hideText();
  is_shown_ = false;
}

void ModelTooltip::Update(const WorldModel& model, QWidget* panel) {
  const ros::WallTime now = ros::WallTime::now();
  if (now - hovered_since_ < kTooltipDelay || now - updated_at_ < kTooltipPeriod) return;
  updated_at_ = now;
  is_shown_ = true;
  QToolTip::showText(QCursor::pos(), TooltipText(model), panel);
  // The mouse acts through it: the view would lose a press on it.
  for (const QWidget* widget : QApplication::topLevelWidgets()) {
    QWindow* window = widget->inherits("QTipLabel") ? widget->windowHandle() : nullptr;
    if (window) window->setFlag(Qt::WindowTransparentForInput);
  }
}

}  // namespace flatland_viz
