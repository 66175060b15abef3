#pragma once

/// Independent pieces of work on all processor cores.

#include <functional>

namespace flatland {

/// Calls `work(i)` for each i from 0 to count - 1, in any order and several at a time, and returns
/// when all are done. `work` must not throw. One set of threads serves the whole process; it is
/// started when it is first needed. While it works for somebody, others do their work by
/// themselves.
void ForEachInParallel(int count, const std::function<void(int)>& work);

}  // namespace flatland
