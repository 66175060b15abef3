#pragma once

/// A base class of rviz displays. rviz's own waits for a transform at the time of each message.

#include <OgreSceneNode.h>
#include <ros/subscriber.h>
#include <rviz/display.h>
#include <rviz/display_context.h>
#include <rviz/frame_manager.h>
#include <rviz/properties/ros_topic_property.h>

#include <string>

namespace flatland_viz {

/// Subscribes to the chosen topic while the display is enabled.
class TopicDisplay : public rviz::Display {
 protected:
  TopicDisplay(const char* type, const char* description)
      : topic_(new rviz::RosTopicProperty("Topic", "", type, description, this)) {
    connect(topic_, &rviz::Property::changed, this, &TopicDisplay::onEnable);
  }

  virtual ros::Subscriber Subscribe(const std::string& topic) = 0;
  /// Removes all that is shown.
  virtual void Clear() = 0;

  void onEnable() override {
    onDisable();
    if (!isEnabled() || topic_->getTopicStd().empty()) return;
    try {
      subscriber_ = Subscribe(topic_->getTopicStd());
      setStatus(rviz::StatusProperty::Ok, "Topic", "OK");
    } catch (const ros::Exception& error) {
      setStatus(rviz::StatusProperty::Error, "Topic", error.what());
    }
  }

  void onDisable() override {
    subscriber_.shutdown();
    Clear();
  }

  /// Moves all that is shown to the present pose of its frame; hides it without a transform.
  void Place(const std::string& frame) {
    Ogre::Vector3 position = Ogre::Vector3::ZERO;
    Ogre::Quaternion orientation = Ogre::Quaternion::IDENTITY;
    const QString name = QString::fromStdString(frame);
    const bool is_known = name == fixed_frame_ || context_->getFrameManager()->getTransform(
                                                      frame, ros::Time(), position, orientation);
    if (is_known) {
      setStatus(rviz::StatusProperty::Ok, "Transform", "OK");
    } else {
      setStatus(rviz::StatusProperty::Error, "Transform",
                QString("no transform from %1 to %2").arg(name, fixed_frame_));
    }
    getSceneNode()->setVisible(is_known);
    getSceneNode()->setPosition(position);
    getSceneNode()->setOrientation(orientation);
  }

  ros::Subscriber subscriber_;  // shut down by destructors of displays, before their members go

 private:
  rviz::RosTopicProperty* topic_;
};

}  // namespace flatland_viz
