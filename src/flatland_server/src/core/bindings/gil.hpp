#pragma once

/// Python's lock (GIL), for threads that may go on while Python ends.
///
/// Need: a daemon thread may step a simulation when the process ends. Python ends each thread that
/// asks for its lock then, by pthread_exit, which unwinds the stack. In a destructor, as of
/// pybind11's gil_scoped_release, this aborts the process.
///
/// Method: such a thread waits until the process has ended, as in Python 3.14.

#include <cxxabi.h>
#include <pybind11/pybind11.h>
#include <unistd.h>

namespace flatland {

/// Calls a function that asks for the lock. It does not return if Python has ended.
template <class Function>
void CallUnlessPythonEnds(Function function) {
  try {
    function();
  } catch (const abi::__forced_unwind&) {
    for (;;) pause();
  }
}

/// Releases the lock as long as it lives.
class ReleasedGil {
 public:
  ReleasedGil() : thread_(PyEval_SaveThread()) {}
  ~ReleasedGil() {
    CallUnlessPythonEnds([this] { PyEval_RestoreThread(thread_); });
  }
  ReleasedGil(const ReleasedGil&) = delete;
  ReleasedGil& operator=(const ReleasedGil&) = delete;

 private:
  PyThreadState* thread_;
};

}  // namespace flatland
