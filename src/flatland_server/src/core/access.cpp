#include "flatland_server/access.hpp"

#include <stdexcept>

namespace flatland {
namespace {

constexpr char kInUse[] = "the world is in use by another thread";
constexpr char kInCallback[] =
    "during contact events nothing can be added, removed, moved or scanned; wait for the end of "
    "the step";

}  // namespace

void Access::RequireAccess() const {
  if (is_in_use_ && !IsInCallback()) throw std::logic_error(kInUse);
}

AccessGuard::AccessGuard(const Access& access) : access_(access) {
  if (!access.is_in_use_.exchange(true)) return;
  throw std::logic_error(access.IsInCallback() ? kInCallback : kInUse);
}

}  // namespace flatland
