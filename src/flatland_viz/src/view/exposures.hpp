#pragma once

/// Notices when the content of an X window is lost: another window was in front of it.

#include <functional>
#include <memory>

namespace flatland_viz {

/// Calls back when a part of an X window must be drawn again.
///
/// Ogre draws into a child of Qt's window. Expose events go only to connections that select those
/// of that child, and neither Qt nor Ogre does.
class Exposures {
 public:
  /// @param window  the id of the X window
  /// @param exposed  called on the thread of Qt's event loop
  Exposures(unsigned long window, std::function<void()> exposed);
  ~Exposures();

 private:
  struct Connection;
  class Notifier;
  std::unique_ptr<Connection> connection_;
  std::unique_ptr<Notifier> notifier_;
};

}  // namespace flatland_viz
