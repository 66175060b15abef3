#include "base/parallel.hpp"

#include <pthread.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <condition_variable>
#include <mutex>
#include <system_error>
#include <thread>

namespace flatland {
namespace {

/// For fewer pieces of work, waking the threads takes longer than the work itself.
constexpr int kMinCount = 4;
constexpr unsigned kMaxThreads = 16;

class Pool {
 public:
  /// Starts fewer threads, or none, if the system refuses to start more.
  explicit Pool(unsigned helpers) {
    try {
      for (unsigned i = 0; i < helpers; ++i) std::thread([this] { Help(); }).detach();
    } catch (const std::system_error&) {
    }
  }

  /// Does the work and returns true, or returns false if the pool is busy.
  bool TryRun(int count, const std::function<void(int)>& work) {
    const std::unique_lock<std::mutex> run(run_mutex_, std::try_to_lock);
    if (!run.owns_lock()) return false;
    {
      const std::lock_guard<std::mutex> lock(mutex_);
      work_ = &work;
      count_ = count;
      next_ = 0;
    }
    wake_.notify_all();
    Work(work, count);
    std::unique_lock<std::mutex> lock(mutex_);
    work_ = nullptr;  // a helper that wakes up only now has nothing to do
    done_.wait(lock, [this] { return helping_ == 0; });
    return true;
  }

 private:
  void Work(const std::function<void(int)>& work, int count) {
    for (int i = next_++; i < count; i = next_++) work(i);
  }

  void Help() {
    std::unique_lock<std::mutex> lock(mutex_);
    while (true) {
      wake_.wait(lock, [this] { return work_ != nullptr && next_ < count_; });
      const std::function<void(int)>& work = *work_;
      const int count = count_;
      ++helping_;
      lock.unlock();
      Work(work, count);
      lock.lock();
      if (--helping_ == 0) done_.notify_one();
    }
  }

  std::mutex run_mutex_;  // held during TryRun
  std::mutex mutex_;      // guards the members below
  std::condition_variable wake_;
  std::condition_variable done_;
  const std::function<void(int)>* work_ = nullptr;
  int count_ = 0;
  int helping_ = 0;
  std::atomic<int> next_{0};
};

/// Never deleted: its threads wait until the process ends. A forked child process has no threads,
/// and so makes a pool of its own.
std::atomic<Pool*> the_pool{nullptr};
std::mutex starting;

Pool* GetPool() {
  Pool* pool = the_pool;
  if (pool != nullptr) return pool;
  const std::lock_guard<std::mutex> lock(starting);
  if (the_pool == nullptr) {
    static const int forks = pthread_atfork([] { starting.lock(); }, [] { starting.unlock(); },
                                            [] {
                                              the_pool = nullptr;
                                              starting.unlock();
                                            });
    static_cast<void>(forks);
    const unsigned cores = std::max(1u, std::thread::hardware_concurrency());
    the_pool = new Pool(std::min(cores, kMaxThreads) - 1);
  }
  return the_pool;
}

}  // namespace

void ForEachInParallel(int count, const std::function<void(int)>& work) {
  if (count >= kMinCount && std::thread::hardware_concurrency() > 1 &&
      GetPool()->TryRun(count, work)) {
    return;
  }
  for (int i = 0; i < count; ++i) work(i);
}

ThreadTeam::~ThreadTeam() {
  if (shared_ != nullptr && process_ == getpid()) Stop();
}

void ThreadTeam::Run(const std::function<void(int)>& work) {
  if (size_ == 1) {
    work(0);
    return;
  }
  if (shared_ == nullptr || process_ != getpid()) Start();
  {
    const std::lock_guard<std::mutex> lock(shared_->mutex);
    shared_->work = &work;
    shared_->working = size_ - 1;
    ++shared_->run;
  }
  shared_->wake.notify_all();
  work(0);
  std::unique_lock<std::mutex> lock(shared_->mutex);
  shared_->done.wait(lock, [this] { return shared_->working == 0; });
}

void ThreadTeam::Start() {
  shared_ = new Shared();
  process_ = getpid();
  try {
    for (int i = 1; i < size_; ++i) {
      Shared* const shared = shared_;
      shared_->threads.emplace_back([shared, i] { Help(*shared, i); });
    }
  } catch (...) {
    Stop();
    throw;
  }
}

void ThreadTeam::Stop() {
  {
    const std::lock_guard<std::mutex> lock(shared_->mutex);
    shared_->ends = true;
  }
  shared_->wake.notify_all();
  for (std::thread& thread : shared_->threads) thread.join();
  delete shared_;
  shared_ = nullptr;
}

void ThreadTeam::Help(Shared& shared, int i) {
  std::unique_lock<std::mutex> lock(shared.mutex);
  int run = 0;
  while (true) {
    shared.wake.wait(lock, [&] { return shared.ends || shared.run != run; });
    if (shared.ends) return;
    const std::function<void(int)>& work = *shared.work;
    run = shared.run;
    lock.unlock();
    work(i);
    lock.lock();
    if (--shared.working == 0) shared.done.notify_one();
  }
}

}  // namespace flatland
