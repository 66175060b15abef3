#pragma once

/// Who may touch a world, and when.

#include <atomic>
#include <stdexcept>

namespace flatland {

inline constexpr char kBusy[] = "the world is in use by another thread";
inline constexpr char kLocked[] =
    "nothing is added, removed, put elsewhere or scanned while contacts are told of; wait for the "
    "end of the step";

/// Marks the world as in use for as long as it lives.
class BusyGuard {
 public:
  BusyGuard(std::atomic<bool>& busy, bool is_listening) : busy_(busy) {
    if (busy_.exchange(true)) throw std::logic_error(is_listening ? kLocked : kBusy);
  }
  ~BusyGuard() { busy_ = false; }
  BusyGuard(const BusyGuard&) = delete;
  BusyGuard& operator=(const BusyGuard&) = delete;

 private:
  std::atomic<bool>& busy_;
};

}  // namespace flatland
