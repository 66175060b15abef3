// flatland_counting_subscriber: subscribes to a simulation's topics and counts messages and bytes.
//
//   flatland_counting_subscriber [--robots] [--clock] [TOPIC ...]
//
//   --robots   every topic known to the master that ends in /scan or /odometry/filtered, and /tf
//   --clock    /clock, and the intervals between its messages
//   TOPIC      a topic of one of these types
//
// With each message of the simulation's state (five a second) it prints a line of JSON: real time,
// simulated time, and the messages and bytes so far. On SIGINT and SIGTERM it ends; with --clock
// its last line has quantiles of the intervals of /clock in real time. It is written in C++ because
// a subscriber in Python needs more processor time than the server that it measures.

#include <flatland_msgs/SimulationState.h>
#include <nav_msgs/Odometry.h>
#include <ros/ros.h>
#include <rosgraph_msgs/Clock.h>
#include <sensor_msgs/LaserScan.h>
#include <tf2_msgs/TFMessage.h>

#include <algorithm>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <map>
#include <string>
#include <vector>

namespace {

constexpr int kQueueSize = 100;
constexpr char kState[] = "/flatland_server/state";

/// Messages and bytes received of one message type.
struct Count {
  unsigned long long messages = 0;
  unsigned long long bytes = 0;
};

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

  /// Subscribes to a topic; returns false if the type is not supported.
  bool Subscribe(const std::string& topic, const std::string& type) {
    return SubscribeTo<sensor_msgs::LaserScan>(topic, type) ||
           SubscribeTo<nav_msgs::Odometry>(topic, type) ||
           SubscribeTo<tf2_msgs::TFMessage>(topic, type) ||
           SubscribeTo<rosgraph_msgs::Clock>(topic, type);
  }

  void SubscribeToClock() {
    clock_ =
        node_.subscribe<rosgraph_msgs::Clock>("/clock", kQueueSize, &CountingSubscriber::OnClock,
                                              this, ros::TransportHints().tcpNoDelay());
  }

  /// Prints the median, the 99th percentile and the longest of the intervals of /clock.
  void ReportClock() {
    if (intervals_.empty()) return;
    std::sort(intervals_.begin(), intervals_.end());
    const auto quantile = [this](double part) {
      return intervals_[static_cast<size_t>(part * static_cast<double>(intervals_.size() - 1))];
    };
    std::printf("{\"clock_intervals\": %zu, \"p50\": %.6f, \"p99\": %.6f, \"worst\": %.6f}\n",
                intervals_.size(), quantile(0.5), quantile(0.99), intervals_.back());
  }

 private:
  template <typename Message>
  bool SubscribeTo(const std::string& topic, const std::string& type) {
    if (type != ros::message_traits::datatype<Message>()) return false;
    Count& count = counts_[type];
    const boost::function<void(const boost::shared_ptr<const Message>&)> received =
        [&count](const boost::shared_ptr<const Message>& message) {
          ++count.messages;
          count.bytes += ros::serialization::serializationLength(*message);
        };
    subscribers_.push_back(node_.subscribe<Message>(
        topic, kQueueSize, received, ros::VoidConstPtr(), ros::TransportHints().tcpNoDelay()));
    return true;
  }

  void OnClock(const rosgraph_msgs::Clock::ConstPtr&) {
    const double now = Now();
    if (last_clock_ > 0.0) intervals_.push_back(now - last_clock_);
    last_clock_ = now;
  }

  void Report(const flatland_msgs::SimulationState::ConstPtr& state) {
    size_t connected = 0;
    for (const auto& subscriber : subscribers_) connected += subscriber.getNumPublishers() > 0;
    std::printf(
        "{\"real\": %.6f, \"simulated\": %.9f, \"topics\": %zu, \"connected\": %zu, \"received\": "
        "{",
        Now(), state->stamp.toSec(), subscribers_.size(), connected);
    const char* separator = "";
    for (const auto& [type, count] : counts_) {
      std::printf("%s\"%s\": {\"messages\": %llu, \"bytes\": %llu}", separator, type.c_str(),
                  count.messages, count.bytes);
      separator = ", ";
    }
    std::printf("}}\n");
    std::fflush(stdout);
  }

  ros::NodeHandle node_;
  ros::Subscriber state_;
  ros::Subscriber clock_;
  std::vector<ros::Subscriber> subscribers_;
  std::map<std::string, Count> counts_;
  double last_clock_ = 0.0;
  std::vector<double> intervals_;
};

/// Keeps roscpp itself from subscribing to /clock, as it does under use_sim_time: the simulation
/// would have one more subscriber to serve.
ros::M_string Remappings(bool clock) {
  return clock ? ros::M_string{} : ros::M_string{{"/clock", "/unused_clock"}};
}

}  // namespace

int main(int argc, char** argv) {
  const std::vector<std::string> arguments(argv + 1, argv + argc);
  const auto is_given = [&arguments](const char* option) {
    return std::find(arguments.begin(), arguments.end(), option) != arguments.end();
  };
  const bool robots = is_given("--robots");
  const bool clock = is_given("--clock");
  ros::init(Remappings(clock), "flatland_counting_subscriber",
            ros::init_options::AnonymousName | ros::init_options::NoRosout |
                ros::init_options::NoSigintHandler);
  for (const int number : {SIGINT, SIGTERM}) {
    std::signal(number, [](int) { ros::requestShutdown(); });
  }

  CountingSubscriber subscriber;
  ros::master::V_TopicInfo topics;
  ros::master::getTopics(topics);
  for (const auto& topic : topics) {
    const bool is_a_robots = topic.name == "/tf" || EndsIn(topic.name, "/scan") ||
                             EndsIn(topic.name, "/odometry/filtered");
    if (!is_given(topic.name.c_str()) && !(robots && is_a_robots)) continue;
    if (!subscriber.Subscribe(topic.name, topic.datatype)) {
      std::fprintf(stderr, "flatland_counting_subscriber: %s: unsupported type %s\n",
                   topic.name.c_str(), topic.datatype.c_str());
      return 1;
    }
  }
  if (clock) subscriber.SubscribeToClock();
  ros::spin();
  subscriber.ReportClock();
}
