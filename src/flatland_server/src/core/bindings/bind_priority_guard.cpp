/// A thread with real-time priority that never pauses would keep a core from everything else.
/// PriorityGuard measures the thread's CPU time with a POSIX timer, and takes its priority away in
/// the timer's signal handler: this works even while native code holds Python's global lock.

#include "bindings/bindings.hpp"

#ifdef __linux__

#include <sched.h>
#include <sys/syscall.h>
#include <time.h>
#include <unistd.h>

#include <cerrno>
#include <cmath>
#include <csignal>
#include <stdexcept>
#include <system_error>

#ifndef sigev_notify_thread_id  // glibc before 2.34
#define sigev_notify_thread_id _sigev_un._tid
#endif

namespace flatland {
namespace {

volatile std::sig_atomic_t priority_taken = 0;
struct sigaction next_action;

/// Runs on the thread that is guarded.
void TakePriorityAway(int signal) {
  const int error = errno;
  sched_param parameters{};
  sched_setscheduler(0, SCHED_OTHER, &parameters);
  priority_taken = 1;
  const auto next = next_action.sa_handler;
  if (next != SIG_DFL && next != SIG_IGN) next(signal);
  errno = error;
}

void Check(int result, const char* what) {
  if (result != 0) throw std::system_error(errno, std::generic_category(), what);
}

/// Guards the thread that creates it. One per process.
class PriorityGuard {
 public:
  explicit PriorityGuard(int signal) {
    priority_taken = 0;
    struct sigaction action {};
    action.sa_handler = TakePriorityAway;
    action.sa_flags = SA_RESTART;
    struct sigaction previous {};
    Check(sigaction(signal, &action, &previous), "sigaction");
    if (previous.sa_handler != TakePriorityAway) next_action = previous;

    sigevent event{};
    event.sigev_notify = SIGEV_THREAD_ID;
    event.sigev_signo = signal;
    event.sigev_notify_thread_id = static_cast<pid_t>(syscall(SYS_gettid));
    Check(timer_create(CLOCK_THREAD_CPUTIME_ID, &event, &timer_), "timer_create");
  }
  PriorityGuard(const PriorityGuard&) = delete;
  PriorityGuard& operator=(const PriorityGuard&) = delete;
  ~PriorityGuard() { timer_delete(timer_); }

  void Arm(double seconds) const {
    if (!(seconds > 0.0 && seconds < 1e6)) {
      throw std::invalid_argument("expected a time above 0 s");
    }
    itimerspec time{};
    time.it_value.tv_sec = static_cast<time_t>(seconds);
    time.it_value.tv_nsec = static_cast<long>(std::fmod(seconds, 1.0) * 1e9);
    Check(timer_settime(timer_, 0, &time, nullptr), "timer_settime");
  }

  void Disarm() const {
    const itimerspec never{};
    Check(timer_settime(timer_, 0, &never, nullptr), "timer_settime");
  }

  bool has_fired() const { return priority_taken != 0; }

 private:
  timer_t timer_;
};

}  // namespace

void BindPriorityGuard(py::module_& m) {
  py::class_<PriorityGuard>(m, "PriorityGuard")
      .def(py::init<int>(), py::arg("signal"))
      .def("arm", &PriorityGuard::Arm, py::arg("seconds"))
      .def("disarm", &PriorityGuard::Disarm)
      .def_property_readonly("has_fired", &PriorityGuard::has_fired);
}

}  // namespace flatland

#else

namespace flatland {

void BindPriorityGuard(py::module_&) {}  // there are no real-time priorities of threads

}  // namespace flatland

#endif
