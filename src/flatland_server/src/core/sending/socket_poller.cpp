#include "sending/socket_poller.hpp"

#include <sys/epoll.h>

#include <array>
#include <thread>

#include "sending/subscriber_queue.hpp"

namespace flatland {

SocketPoller& SocketPoller::Get() {
  static auto* const poller = new SocketPoller;
  return *poller;
}

SocketPoller::SocketPoller() : epoll_(epoll_create1(EPOLL_CLOEXEC)) {
  std::thread([this] { Run(); }).detach();
}

bool SocketPoller::Watch(const std::shared_ptr<SubscriberQueue>& queue) {
  const int socket = queue->socket_;
  {
    const std::lock_guard lock(mutex_);
    queues_[socket] = queue;
  }
  epoll_event event{};
  event.events = EPOLLOUT | EPOLLONESHOT;
  event.data.fd = socket;
  return epoll_ctl(epoll_, EPOLL_CTL_ADD, socket, &event) == 0 ||
         epoll_ctl(epoll_, EPOLL_CTL_MOD, socket, &event) == 0;
}

void SocketPoller::Forget(int socket) {
  const std::lock_guard lock(mutex_);
  queues_.erase(socket);
  epoll_ctl(epoll_, EPOLL_CTL_DEL, socket, nullptr);
}

std::shared_ptr<SubscriberQueue> SocketPoller::Take(int socket) {
  const std::lock_guard lock(mutex_);
  const auto found = queues_.find(socket);
  if (found == queues_.end()) return nullptr;
  auto queue = found->second.lock();
  queues_.erase(found);
  return queue;
}

void SocketPoller::Run() {
  std::array<epoll_event, 64> events{};
  for (;;) {
    const int count = epoll_wait(epoll_, events.data(), events.size(), -1);
    for (int i = 0; i < count; ++i) {
      const auto queue = Take(events[static_cast<std::size_t>(i)].data.fd);
      if (queue == nullptr) continue;
      const std::lock_guard lock(queue->mutex_);
      queue->is_polled_ = false;
      queue->SendMessages();  // none, if it was closed
    }
  }
}

}  // namespace flatland
