// flatland_message_sender: sends the same messages again and again to subscribers that are
// connected already. It does nothing else: the speed that it reaches is the limit of a simulator
// with these subscribers on this machine. `flatland_benchmark.message_sender` starts it.
//
//   flatland_message_sender STEP_SIZE STEPS
//
//   STEP_SIZE   simulated time of a step [s]
//   STEPS       messages of this many steps go to a subscriber in one call
//
// Each line of standard input is a socket: its descriptor, the number of steps between its
// messages, and a file with the message as it is sent. With 0 steps the message is the simulation's
// state: it is sent five times a second, with the simulated time of the last step in it.

#include <sys/socket.h>

#include <chrono>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <iostream>
#include <iterator>
#include <string>
#include <vector>

namespace {

using Clock = std::chrono::steady_clock;

constexpr size_t kStampAt = 4;  // behind the length
constexpr std::chrono::milliseconds kStatePeriod(200);

struct Subscriber {
  int socket;
  int64_t every;
  std::string message;
  std::string waiting;
};

/// Sends all of it; waits while the socket is full. Ends the program when the subscriber has ended.
void Send(int socket, const std::string& bytes) {
  for (size_t sent = 0; sent < bytes.size();) {
    const ssize_t count = send(socket, bytes.data() + sent, bytes.size() - sent, MSG_NOSIGNAL);
    if (count < 0) std::exit(0);
    sent += static_cast<size_t>(count);
  }
}

void SendState(Subscriber& state, int64_t nanoseconds) {
  const uint32_t stamp[] = {static_cast<uint32_t>(nanoseconds / 1000000000),
                            static_cast<uint32_t>(nanoseconds % 1000000000)};
  std::memcpy(state.message.data() + kStampAt, stamp, sizeof(stamp));
  Send(state.socket, state.message);
}

std::vector<Subscriber> ReadSubscribers() {
  std::vector<Subscriber> subscribers;
  Subscriber next{};
  std::string file;
  while (std::cin >> next.socket >> next.every >> file) {
    std::ifstream stream(file, std::ios::binary);
    next.message.assign(std::istreambuf_iterator<char>(stream), {});
    subscribers.push_back(next);
  }
  return subscribers;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 3) return 2;
  const auto step = static_cast<int64_t>(std::atof(argv[1]) * 1e9);
  const int64_t steps = std::atoll(argv[2]);
  std::vector<Subscriber> subscribers = ReadSubscribers();
  Clock::time_point state_due = Clock::now();
  for (int64_t done = 0;; done += steps) {
    for (Subscriber& each : subscribers) {
      if (each.every == 0) continue;
      each.waiting.clear();
      for (int64_t i = done; i < done + steps; ++i) {
        if (i % each.every == 0) each.waiting += each.message;
      }
      Send(each.socket, each.waiting);
    }
    if (Clock::now() < state_due) continue;
    state_due = Clock::now() + kStatePeriod;
    for (Subscriber& each : subscribers) {
      if (each.every == 0) SendState(each, (done + steps) * step);
    }
  }
}
