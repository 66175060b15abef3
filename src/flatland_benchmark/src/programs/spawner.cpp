// flatland_spawner: measures how long a call of /spawn_model takes.
//
//   flatland_spawner MODEL.yaml COUNT
//
// Spawns that many models one after the other, each in a namespace of its own, and deletes each
// before the next. Prints a line of JSON: the duration of each call in seconds of real time.

#include <flatland_msgs/DeleteModel.h>
#include <flatland_msgs/SpawnModel.h>
#include <ros/ros.h>

#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <string>

namespace {

/// Calls a service; ends the program with an error message if the call fails.
template <typename Service>
void Call(ros::ServiceClient& client, Service& service) {
  if (client.call(service) && service.response.success) return;
  std::fprintf(stderr, "flatland_spawner: %s: %s\n", client.getService().c_str(),
               service.response.message.c_str());
  std::exit(1);
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 3) {
    std::fprintf(stderr, "usage: flatland_spawner MODEL.yaml COUNT\n");
    return 2;
  }
  ros::init(ros::M_string{{"/clock", "/unused_clock"}}, "flatland_spawner",
            ros::init_options::AnonymousName | ros::init_options::NoRosout);
  ros::NodeHandle node;
  auto spawn = node.serviceClient<flatland_msgs::SpawnModel>("/spawn_model", true);
  auto remove = node.serviceClient<flatland_msgs::DeleteModel>("/delete_model", true);
  spawn.waitForExistence();
  remove.waitForExistence();

  const int count = std::atoi(argv[2]);
  std::printf("{\"spawned\": [");
  for (int i = 0; i < count; ++i) {
    flatland_msgs::SpawnModel spawning;
    spawning.request.yaml_path = argv[1];
    spawning.request.name = "spawned_" + std::to_string(i);
    spawning.request.ns = spawning.request.name;
    const auto begin = std::chrono::steady_clock::now();
    Call(spawn, spawning);
    const std::chrono::duration<double> seconds = std::chrono::steady_clock::now() - begin;
    std::printf("%s%.6f", i ? ", " : "", seconds.count());

    flatland_msgs::DeleteModel deleting;
    deleting.request.name = spawning.request.name;
    Call(remove, deleting);
  }
  std::printf("]}\n");
}
