// flatland_counting_subscriber: subscribes to a simulation's topics and counts messages.
//
//   flatland_counting_subscriber [--robots]
//
//   --robots   every topic known to the master that ends in /scan or /odometry/filtered, and /tf
//
// With each message of the simulation's state (five a second) it prints a line of JSON: real time,
// simulated time, the messages so far, and how many are missing between them. It is written in C++
// because a subscriber in Python needs more processor time than the server that it measures.

#include <flatland_msgs/SimulationState.h>
#include <nav_msgs/Odometry.h>
#include <ros/ros.h>
#include <sensor_msgs/LaserScan.h>
#include <tf2_msgs/TFMessage.h>

#include <chrono>
#include <cstdint>
#include <cstdio>
#include <map>
#include <string>
#include <vector>

namespace {

constexpr int kQueueSize = 10000;  // at 100 times real time, 100 are those of 5 ms
constexpr char kState[] = "/flatland_server/state";

/// The monotonic clock [s], the same as Python's time.monotonic().
double Now() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

bool EndsIn(const std::string& text, const std::string& end) {
  return text.size() >= end.size() && !text.compare(text.size() - end.size(), end.size(), end);
}

/// Subscribes, counts and reports.
class CountingSubscriber {
 public:
  CountingSubscriber() {
    state_ = node_.subscribe<flatland_msgs::SimulationState>(
        kState, kQueueSize, &CountingSubscriber::Report, this, ros::TransportHints().tcpNoDelay());
  }

  template <typename Message>
  void Subscribe(const std::string& topic) {
    unsigned long long& count = counts_[ros::message_traits::datatype<Message>()];
    const boost::function<void(const boost::shared_ptr<const Message>&)> received =
        [this, &count,
         last = std::uint32_t{0}](const boost::shared_ptr<const Message>& message) mutable {
          ++count;
          const std_msgs::Header* header = ros::message_traits::header(*message);
          if (!header) return;
          if (last) missing_ += header->seq - last - 1;
          last = header->seq;
        };
    subscribers_.push_back(node_.subscribe<Message>(
        topic, kQueueSize, received, ros::VoidConstPtr(), ros::TransportHints().tcpNoDelay()));
  }

 private:
  void Report(const flatland_msgs::SimulationState::ConstPtr& state) {
    size_t connected = 0;
    for (const auto& subscriber : subscribers_) connected += subscriber.getNumPublishers() > 0;
    std::printf(
        "{\"real\": %.6f, \"simulated\": %.9f, \"topics\": %zu, \"connected\": %zu, \"missing\": "
        "%llu, \"received\": {",
        Now(), state->stamp.toSec(), subscribers_.size(), connected, missing_);
    const char* separator = "";
    for (const auto& [type, count] : counts_) {
      std::printf("%s\"%s\": %llu", separator, type.c_str(), count);
      separator = ", ";
    }
    std::printf("}}\n");
    std::fflush(stdout);
  }

  ros::NodeHandle node_;
  ros::Subscriber state_;
  std::vector<ros::Subscriber> subscribers_;
  std::map<std::string, unsigned long long> counts_;  // of messages, by type
  unsigned long long missing_ = 0;                    // by the numbers in headers
};

}  // namespace

int main(int argc, char** argv) {
  // Remapped, or roscpp itself would subscribe to /clock, as it does under use_sim_time: the
  // simulation would have one more subscriber to serve.
  ros::init(ros::M_string{{"/clock", "/unused_clock"}}, "flatland_counting_subscriber",
            ros::init_options::AnonymousName | ros::init_options::NoRosout);
  CountingSubscriber subscriber;
  ros::master::V_TopicInfo topics;
  if (argc > 1 && std::string(argv[1]) == "--robots") ros::master::getTopics(topics);
  for (const auto& [name, type] : topics) {
    if (EndsIn(name, "/scan")) subscriber.Subscribe<sensor_msgs::LaserScan>(name);
    if (EndsIn(name, "/odometry/filtered")) subscriber.Subscribe<nav_msgs::Odometry>(name);
    if (name == "/tf") subscriber.Subscribe<tf2_msgs::TFMessage>(name);
  }
  ros::spin();
}
