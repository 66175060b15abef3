#include "base/access.hpp"

#include <stdexcept>

namespace flatland {

void Access::Refuse() const {
  throw std::logic_error(IsInCallback() ? "during contact events nothing can be added, removed, "
                                          "moved or scanned; wait for the end of the step"
                                        : "the world is in use by another thread");
}

}  // namespace flatland
