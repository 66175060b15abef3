#pragma once

/// The number of random cases that a test tries.

/// Of AddressSanitizer's library; null in a program that is not linked with it.
extern "C" __attribute__((weak)) void __asan_init();

namespace flatland {

/// All of them in the plain test, a quarter with sanitizers, which take several times as long: each
/// case reads and writes the same memory, and the plain test checks the results.
inline int Rounds(int count) { return __asan_init != nullptr ? count / 4 : count; }

}  // namespace flatland
