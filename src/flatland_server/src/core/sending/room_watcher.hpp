#pragma once

#include <memory>
#include <mutex>
#include <unordered_map>

namespace flatland {

class SubscriberQueue;

/// The thread that sends what is left in queues, as soon as their sockets have room.
class RoomWatcher {
 public:
  /// The only one. It is never destroyed: its thread waits until the process ends.
  static RoomWatcher& Get();

  /// Sends the rest of a queue once. Returns false if the system cannot watch its socket.
  bool Watch(const std::shared_ptr<SubscriberQueue>& queue);
  /// To be called before a socket that is watched is closed.
  void Forget(int socket);

 private:
  RoomWatcher();
  void Run();
  std::shared_ptr<SubscriberQueue> Take(int socket);

  int epoll_;
  std::mutex mutex_;
  std::unordered_map<int, std::weak_ptr<SubscriberQueue>> queues_;  // by their sockets
};

}  // namespace flatland
