#pragma once

/// Exclusive access: an object is used by one thread at a time.

#include <atomic>
#include <thread>

namespace flatland {

class AccessGuard;

/// Base of an object that only one thread at a time may use. An AccessGuard marks the use. A
/// callback that the object makes runs within that guard: it may use the object, but must not
/// create another guard.
class Access {
 public:
  using AccessGuard = flatland::AccessGuard;

  /// Throws std::logic_error if the object is in use, unless this is called within its callback.
  void RequireAccess() const {
    if (is_in_use_ && !IsInCallback()) Refuse();
  }
  /// Throws std::logic_error if the object is in use, also within a callback.
  void RequireIdle() const {
    if (is_in_use_) Refuse();
  }
  /// True if this thread is within a callback.
  bool IsInCallback() const { return callback_thread_ == std::this_thread::get_id(); }
  /// Calls `callback`, during which RequireAccess accepts this thread.
  template <class Callback>
  void CallBack(Callback callback) {
    callback_thread_ = std::this_thread::get_id();
    callback();
    callback_thread_ = std::thread::id();
  }

 private:
  friend class flatland::AccessGuard;

  [[noreturn]] void Refuse() const;

  mutable std::atomic<bool> is_in_use_{false};
  std::atomic<std::thread::id> callback_thread_{};  // set during a callback
};

/// Marks an object as in use while it exists; throws std::logic_error if it is in use already.
/// Functions that change the structure of a world, step or scan create one themselves. Callers
/// that release a lock during a step or a scan, as the Python bindings do with the GIL, create it
/// before they release the lock: then other threads always find the world marked.
class AccessGuard {
 public:
  explicit AccessGuard(const Access& access) : access_(access) {
    if (access.is_in_use_.exchange(true)) access.Refuse();
  }
  ~AccessGuard() { access_.is_in_use_ = false; }
  AccessGuard(const AccessGuard&) = delete;
  AccessGuard& operator=(const AccessGuard&) = delete;

 private:
  const Access& access_;
};

}  // namespace flatland
