// flatland_listener: hears what a simulation publishes, and says how much that is.
//
//   flatland_listener [--robots] [--clock] [TOPIC ...]
//
//   --robots   every topic of the master's that ends in /scan or /odometry/filtered, and /tf
//   --clock    /clock, too
//   TOPIC      of one of these types; asked of the master
//
// At every message of the simulation's state (five a second) it prints a line of JSON: the time
// here and there, and the messages and bytes so far. On SIGINT and SIGTERM it ends; with --clock
// its last line is about the intervals at which /clock came, in real time. It is written in C++
// because a listener in Python is slower than what it listens to.

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

/// What has come of one type.
struct Count {
  unsigned long long messages = 0;
  unsigned long long bytes = 0;
};

/// Seconds of real time since some moment; Python's time.monotonic() has the same.
double Now() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

bool EndsIn(const std::string& text, const std::string& end) {
  return text.size() >= end.size() && !text.compare(text.size() - end.size(), end.size(), end);
}

/// Subscribes, counts and reports.
class Listener {
 public:
  Listener() {
    state_ = node_.subscribe<flatland_msgs::SimulationState>(
        kState, kQueueSize, &Listener::Report, this, ros::TransportHints().tcpNoDelay());
  }

  /// Returns whether the type is one that it knows.
  bool Listen(const std::string& topic, const std::string& type) {
    return ListenTo<sensor_msgs::LaserScan>(topic, type) ||
           ListenTo<nav_msgs::Odometry>(topic, type) ||
           ListenTo<tf2_msgs::TFMessage>(topic, type) ||
           ListenTo<rosgraph_msgs::Clock>(topic, type);
  }

  void ListenToClock() {
    clock_ = node_.subscribe<rosgraph_msgs::Clock>("/clock", kQueueSize, &Listener::OnClock, this,
                                                   ros::TransportHints().tcpNoDelay());
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
  bool ListenTo(const std::string& topic, const std::string& type) {
    if (type != ros::message_traits::datatype<Message>()) return false;
    Count& count = counts_[type];
    const boost::function<void(const boost::shared_ptr<const Message>&)> heard =
        [&count](const boost::shared_ptr<const Message>& message) {
          ++count.messages;
          count.bytes += ros::serialization::serializationLength(*message);
        };
    subscribers_.push_back(node_.subscribe<Message>(topic, kQueueSize, heard, ros::VoidConstPtr(),
                                                    ros::TransportHints().tcpNoDelay()));
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
        "{\"real\": %.6f, \"simulated\": %.9f, \"topics\": %zu, \"connected\": %zu, \"heard\": {",
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

/// The names as they are, but for /clock: under use_sim_time roscpp itself would listen to it, and
/// the simulation would have to send it.
ros::M_string Remappings(bool clock) {
  return clock ? ros::M_string{} : ros::M_string{{"/clock", "/nobodys_clock"}};
}

}  // namespace

int main(int argc, char** argv) {
  const std::vector<std::string> arguments(argv + 1, argv + argc);
  const auto is_given = [&arguments](const char* option) {
    return std::find(arguments.begin(), arguments.end(), option) != arguments.end();
  };
  const bool robots = is_given("--robots");
  const bool clock = is_given("--clock");
  ros::init(Remappings(clock), "flatland_listener",
            ros::init_options::AnonymousName | ros::init_options::NoRosout |
                ros::init_options::NoSigintHandler);
  for (const int number : {SIGINT, SIGTERM}) {
    std::signal(number, [](int) { ros::requestShutdown(); });
  }

  Listener listener;
  ros::master::V_TopicInfo topics;
  ros::master::getTopics(topics);
  for (const auto& topic : topics) {
    const bool is_a_robots = topic.name == "/tf" || EndsIn(topic.name, "/scan") ||
                             EndsIn(topic.name, "/odometry/filtered");
    if (!is_given(topic.name.c_str()) && !(robots && is_a_robots)) continue;
    if (!listener.Listen(topic.name, topic.datatype)) {
      std::fprintf(stderr, "flatland_listener: %s is a %s, which it does not know\n",
                   topic.name.c_str(), topic.datatype.c_str());
      return 1;
    }
  }
  if (clock) listener.ListenToClock();
  ros::spin();
  listener.ReportClock();
}
