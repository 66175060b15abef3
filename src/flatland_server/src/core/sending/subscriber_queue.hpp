#pragma once

/// Messages on their way to the sockets of subscribers.
///
/// Need: a hundred robots publish thousands of messages in a second of simulated time, and ten
/// times as many when it passes ten times as fast. A system call takes as long as several steps of
/// a small world, and a slow subscriber must not delay the simulation.
///
/// Method: each subscriber to a topic has a queue. Publishing only adds a message. `Outbox::Send`
/// sends all queues, each in one system call, as far as its socket takes messages without blocking.
/// The others stay in the queue. If there are more than `limit`, the oldest are dropped, except
/// those that have waited for less than `patience`: so long it may take until the system runs a
/// subscriber that keeps up. One thread for all queues waits until such sockets have room, and
/// sends the rest. None of this needs Python's lock.

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

namespace flatland {

class SubscriberQueue : public std::enable_shared_from_this<SubscriberQueue> {
 public:
  using Seconds = std::chrono::duration<double>;

  /// @param socket  descriptor; the queue has its own, of the same connection
  /// @param limit  number of messages that wait while the socket is full; 0: any number
  /// @param patience  time for which messages beyond the limit are kept
  /// Throws std::system_error if there is no such descriptor, or there are too many.
  SubscriberQueue(int socket, std::size_t limit, Seconds patience);
  ~SubscriberQueue() { Close(); }
  SubscriberQueue(const SubscriberQueue&) = delete;
  SubscriberQueue& operator=(const SubscriberQueue&) = delete;

  /// Adds a message as it is sent, with its length before it. Returns how many were added since the
  /// last `Send`; 0 if the connection has failed.
  std::size_t Add(std::string framed);
  /// Sends what the socket takes. Returns false if the connection has failed.
  bool Send();
  /// Forgets the messages; the connection counts as failed. Its owner closes it.
  void Close();

  struct Status {
    uint64_t bytes = 0;     // sent
    uint64_t messages = 0;  // sent as a whole
    int error = 0;          // the errno with which sending has failed, or 0
  };
  Status status() const;

 private:
  class Poller;
  using Clock = std::chrono::steady_clock;

  struct Message {
    std::string bytes;
    Clock::time_point left = {};  // when the socket was first full for it
  };

  void SendMessages();  // these need the lock
  void DropOldest(std::size_t fresh);
  void Fail(int error);

  mutable std::mutex mutex_;
  int socket_;
  std::size_t limit_;
  Seconds patience_;
  std::deque<Message> messages_;  // not sent yet
  std::size_t sent_ = 0;          // bytes of the first one that are sent
  bool is_polled_ = false;        // the thread will send
  std::size_t held_ = 0;          // messages since the last `Send`
  Status status_;
};

/// The queues with waiting messages, ordered by the time of the first one.
class Outbox {
 public:
  using Seconds = SubscriberQueue::Seconds;

  /// @param period  longest time that a message should wait, real time
  /// @param most  number of waiting messages in a queue that makes them due
  Outbox(Seconds period, std::size_t most) : period_(period), most_(most) {}

  /// Adds a message to a queue, to be sent later. Returns false if its connection has failed.
  bool Add(const std::shared_ptr<SubscriberQueue>& queue, std::string framed);
  bool is_empty() const;
  /// True if a message has waited for `period`, or a queue has `most` of them.
  bool IsDue() const;
  /// Sends what waits. Returns false if a connection has failed.
  bool Send();

 private:
  mutable std::mutex mutex_;
  Seconds period_;
  std::size_t most_;
  std::vector<std::shared_ptr<SubscriberQueue>> queues_;
  std::chrono::steady_clock::time_point since_;  // the first message
  bool is_full_ = false;
};

}  // namespace flatland
