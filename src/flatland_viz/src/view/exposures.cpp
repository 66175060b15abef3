#include "exposures.hpp"

#include <QEvent>
#include <QSocketNotifier>
#include <utility>

// clang-format off
#include <X11/Xlib.h>  // last: it defines macros such as None and Bool
// clang-format on

namespace flatland_viz {

/// A separate connection to the X server, for events that no other part asks for.
struct Exposures::Connection {
  Connection() : display(XOpenDisplay(nullptr)) {}
  ~Connection() {
    if (display) XCloseDisplay(display);
  }
  Display* display;
};

class Exposures::Notifier : public QSocketNotifier {
 public:
  Notifier(Display* display, std::function<void()> exposed)
      : QSocketNotifier(ConnectionNumber(display), QSocketNotifier::Read),
        display_(display),
        exposed_(std::move(exposed)) {}

 protected:
  bool event(QEvent* event) override {
    if (event->type() != QEvent::SockAct) return QSocketNotifier::event(event);
    bool is_exposed = false;
    while (XPending(display_) > 0) {
      XEvent from_server;
      XNextEvent(display_, &from_server);
      is_exposed |= from_server.type == Expose;
    }
    if (is_exposed) exposed_();
    return true;
  }

 private:
  Display* display_;
  std::function<void()> exposed_;
};

Exposures::Exposures(unsigned long window, std::function<void()> exposed)
    : connection_(std::make_unique<Connection>()) {
  Display* display = connection_->display;
  if (!display) return;
  XSelectInput(display, window, ExposureMask);
  XFlush(display);
  notifier_ = std::make_unique<Notifier>(display, std::move(exposed));
}

Exposures::~Exposures() = default;

}  // namespace flatland_viz
