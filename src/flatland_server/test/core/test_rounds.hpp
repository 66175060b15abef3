#pragma once

/// How many random cases a test tries.

namespace flatland {

/// All of them in the plain test. With sanitizers, which take ten times as long, a quarter: each
/// case reads and writes the same memory, and whether its result is right the plain test shows.
constexpr int Rounds(int count) {
#ifdef __SANITIZE_ADDRESS__
  return count / 4;
#else
  return count;
#endif
}

}  // namespace flatland
