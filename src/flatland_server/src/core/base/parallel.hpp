#pragma once

/// Independent pieces of work on several processor cores.

#include <condition_variable>
#include <functional>
#include <mutex>
#include <thread>
#include <vector>

namespace flatland {

/// Calls `work(i)` for each i from 0 to count - 1, in any order and in parallel, and returns when
/// all calls have returned. `work` must not throw. The process has one thread pool, started on
/// first use. While it is busy with one call, other calls run on the calling thread alone.
void ForEachInParallel(int count, const std::function<void(int)>& work);

/// A fixed number of threads, the calling one among them, that share work in equal parts.
class ThreadTeam {
 public:
  /// `size` threads, 1 at least. They are started when they are first needed; in a forked child
  /// process, again.
  explicit ThreadTeam(int size) : size_(size > 1 ? size : 1) {}
  ~ThreadTeam();
  ThreadTeam(const ThreadTeam&) = delete;
  ThreadTeam& operator=(const ThreadTeam&) = delete;

  int size() const { return size_; }
  /// Index of the first of `count` items that thread `i` works on; `count` for i = size().
  int Begin(int i, int count) const {
    return static_cast<int>(static_cast<long long>(count) * i / size_);
  }
  /// Calls `work(i)` on each thread i from 0 to size() - 1, and returns when all have returned.
  /// `work` must not throw. Throws std::system_error if the system starts no more threads.
  void Run(const std::function<void(int)>& work);

 private:
  /// State shared by the threads. A forked child process does not touch that of its parent.
  struct Shared {
    std::mutex mutex;  // guards the members below
    std::condition_variable wake;
    std::condition_variable done;
    const std::function<void(int)>* work = nullptr;
    int run = 0;      // incremented by each Run
    int working = 0;  // threads that have not finished this run
    bool ends = false;
    std::vector<std::thread> threads;
  };

  void Start();
  void Stop();
  static void Help(Shared& shared, int i);

  int size_;
  Shared* shared_ = nullptr;
  int process_ = 0;  // id of the process that started the threads
};

}  // namespace flatland
