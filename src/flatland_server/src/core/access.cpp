#include "flatland_server/access.hpp"

#include <stdexcept>

namespace flatland {
namespace {

constexpr char kInUse[] = "the world is in use by another thread";
constexpr char kInCallback[] =
    "during contact events nothing can be added, removed, moved or scanned; wait for the end of "
    "the step";

}  // namespace

void Access::Refuse() const { throw std::logic_error(IsInCallback() ? kInCallback : kInUse); }

}  // namespace flatland
