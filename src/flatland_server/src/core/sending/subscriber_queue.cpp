#include "sending/subscriber_queue.hpp"

#include <fcntl.h>
#include <sys/epoll.h>
#include <sys/socket.h>
#include <sys/uio.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <system_error>
#include <thread>
#include <unordered_map>
#include <utility>

namespace flatland {
namespace {

constexpr std::size_t kMostPieces = 256;  // in one call; Linux takes 1,024

}  // namespace

/// The thread that sends the rest of queues when their sockets are writable again (epoll).
class SubscriberQueue::Poller {
 public:
  /// The only one. It is never destroyed: its thread waits until the process ends.
  static Poller& Get();

  /// Sends the rest of a queue, once, when its socket is writable. Returns false if the system
  /// cannot poll the socket.
  bool Watch(const std::shared_ptr<SubscriberQueue>& queue);
  /// Must be called before a polled socket is closed.
  void Forget(int socket);

 private:
  Poller();
  void Run();
  std::shared_ptr<SubscriberQueue> Take(int socket);

  int epoll_;
  std::mutex mutex_;
  std::unordered_map<int, std::weak_ptr<SubscriberQueue>> queues_;  // by socket
};

SubscriberQueue::Poller& SubscriberQueue::Poller::Get() {
  static auto* const poller = new Poller;
  return *poller;
}

SubscriberQueue::Poller::Poller() : epoll_(epoll_create1(EPOLL_CLOEXEC)) {
  std::thread([this] { Run(); }).detach();
}

bool SubscriberQueue::Poller::Watch(const std::shared_ptr<SubscriberQueue>& queue) {
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

void SubscriberQueue::Poller::Forget(int socket) {
  const std::lock_guard lock(mutex_);
  queues_.erase(socket);
  epoll_ctl(epoll_, EPOLL_CTL_DEL, socket, nullptr);
}

std::shared_ptr<SubscriberQueue> SubscriberQueue::Poller::Take(int socket) {
  const std::lock_guard lock(mutex_);
  const auto found = queues_.find(socket);
  if (found == queues_.end()) return nullptr;
  auto queue = found->second.lock();
  queues_.erase(found);
  return queue;
}

void SubscriberQueue::Poller::Run() {
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

SubscriberQueue::SubscriberQueue(int socket, std::size_t limit, Seconds patience)
    : socket_(fcntl(socket, F_DUPFD_CLOEXEC, 0)), limit_(limit), patience_(patience) {
  if (socket_ < 0) throw std::system_error(errno, std::generic_category(), "a subscriber's socket");
}

std::size_t SubscriberQueue::Add(std::string framed) {
  const std::lock_guard lock(mutex_);
  if (status_.error != 0) return 0;
  messages_.push_back({std::move(framed)});
  return ++held_;
}

bool SubscriberQueue::Send() {
  const std::lock_guard lock(mutex_);
  const std::size_t fresh = std::exchange(held_, 0);
  if (!is_polled_) SendMessages();
  if (!messages_.empty()) DropOldest(std::min(fresh, messages_.size()));
  return status_.error == 0;
}

void SubscriberQueue::SendMessages() {
  std::array<iovec, kMostPieces> pieces{};
  while (!messages_.empty()) {
    const std::size_t count = std::min(messages_.size(), pieces.size());
    for (std::size_t i = 0; i < count; ++i) {
      std::string& bytes = messages_[i].bytes;
      pieces[i] = {bytes.data(), bytes.size()};
    }
    std::string& first = messages_[0].bytes;
    pieces[0] = {first.data() + sent_, first.size() - sent_};
    msghdr header{};
    header.msg_iov = pieces.data();
    header.msg_iovlen = count;
    const ssize_t result = sendmsg(socket_, &header, MSG_DONTWAIT | MSG_NOSIGNAL);
    if (result < 0) {
      if (errno == EINTR) continue;
      if (errno != EAGAIN && errno != EWOULDBLOCK) return Fail(errno);
      is_polled_ = Poller::Get().Watch(shared_from_this());
      return;
    }
    status_.bytes += static_cast<uint64_t>(result);
    sent_ += static_cast<std::size_t>(result);
    while (!messages_.empty() && sent_ >= messages_.front().bytes.size()) {
      sent_ -= messages_.front().bytes.size();
      messages_.pop_front();
      ++status_.messages;
    }
  }
}

void SubscriberQueue::DropOldest(std::size_t fresh) {
  const Clock::time_point now = Clock::now();
  for (auto each = messages_.end() - static_cast<std::ptrdiff_t>(fresh); each != messages_.end();
       ++each) {
    each->left = now;
  }
  const std::size_t begin = sent_ > 0 ? 1 : 0;  // a message is sent as a whole
  if (limit_ == 0 || messages_.size() <= begin + limit_) return;
  const auto first = messages_.begin() + static_cast<std::ptrdiff_t>(begin);
  const auto kept = messages_.end() - static_cast<std::ptrdiff_t>(limit_);
  messages_.erase(first, std::find_if(first, kept, [&](const Message& message) {
                    return now - message.left < patience_;
                  }));
}

void SubscriberQueue::Fail(int error) {
  status_.error = error;
  messages_.clear();
  sent_ = 0;
}

void SubscriberQueue::Close() {
  const std::lock_guard lock(mutex_);
  if (socket_ < 0) return;
  if (is_polled_) Poller::Get().Forget(socket_);
  close(socket_);
  socket_ = -1;
  Fail(status_.error != 0 ? status_.error : ENOTCONN);
}

SubscriberQueue::Status SubscriberQueue::status() const {
  const std::lock_guard lock(mutex_);
  return status_;
}

bool Outbox::Add(const std::shared_ptr<SubscriberQueue>& queue, std::string framed) {
  const std::size_t held = queue->Add(std::move(framed));
  if (held > 1 && held < most_) return true;
  const std::lock_guard lock(mutex_);
  if (held >= most_) is_full_ = true;
  if (held <= 1) {  // or it has failed, which `Send` reports
    if (queues_.empty()) since_ = std::chrono::steady_clock::now();
    queues_.push_back(queue);
  }
  return held > 0;
}

bool Outbox::is_empty() const {
  const std::lock_guard lock(mutex_);
  return queues_.empty();
}

bool Outbox::IsDue() const {
  const std::lock_guard lock(mutex_);
  return is_full_ || (!queues_.empty() && std::chrono::steady_clock::now() - since_ >= period_);
}

bool Outbox::Send() {
  std::vector<std::shared_ptr<SubscriberQueue>> queues;
  {
    const std::lock_guard lock(mutex_);
    queues.swap(queues_);
    is_full_ = false;
  }
  bool are_sound = true;
  for (const auto& queue : queues) are_sound &= queue->Send();
  return are_sound;
}

}  // namespace flatland
