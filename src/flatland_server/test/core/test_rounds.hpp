#pragma once

/// How many random cases a test tries.

/// Of AddressSanitizer's library; null in a program that is not linked with it.
extern "C" __attribute__((weak)) void __asan_init();

namespace flatland {

/// All of them in the plain test. With sanitizers, which take several times as long, a quarter:
/// each case reads and writes the same memory, and whether its result is right the plain test
/// shows.
inline int Rounds(int count) { return __asan_init != nullptr ? count / 4 : count; }

}  // namespace flatland
