#pragma once

#include <memory>
#include <mutex>
#include <unordered_map>

namespace flatland {

class SubscriberQueue;

/// The thread that sends the rest of queues when their sockets are writable again (epoll).
class SocketPoller {
 public:
  /// The only one. It is never destroyed: its thread waits until the process ends.
  static SocketPoller& Get();

  /// Sends the rest of a queue, once, when its socket is writable. Returns false if the system
  /// cannot poll the socket.
  bool Watch(const std::shared_ptr<SubscriberQueue>& queue);
  /// Must be called before a polled socket is closed.
  void Forget(int socket);

 private:
  SocketPoller();
  void Run();
  std::shared_ptr<SubscriberQueue> Take(int socket);

  int epoll_;
  std::mutex mutex_;
  std::unordered_map<int, std::weak_ptr<SubscriberQueue>> queues_;  // by socket
};

}  // namespace flatland
