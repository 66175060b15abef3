#pragma once

/// Independent pieces of work on all processor cores.

#include <functional>

namespace flatland {

/// Calls `work(i)` for each i from 0 to count - 1, in any order and in parallel, and returns when
/// all calls have returned. `work` must not throw. The process has one thread pool, started on
/// first use. While it is busy with one call, other calls run on the calling thread alone.
void ForEachInParallel(int count, const std::function<void(int)>& work);

}  // namespace flatland
