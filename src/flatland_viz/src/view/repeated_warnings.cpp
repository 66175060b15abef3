/// Warnings of tf2, which come with every transform that it ignores: hundreds a second.

#include <console_bridge/console.h>

#include <mutex>
#include <set>
#include <string>

namespace {

/// Receives the text of a warning, on any thread.
using Report = void (*)(const char* text);

/// The part of a warning that is the same when it comes again: without its time.
std::string Subject(const std::string& text) { return text.substr(0, text.find(" at time ")); }

/// Prints each warning once, and reports all of them.
class OncePrinted : public console_bridge::OutputHandler {
 public:
  OncePrinted(Report report, console_bridge::OutputHandler* former)
      : report_(report), former_(former) {}

  void log(const std::string& text, console_bridge::LogLevel level, const char* file,
           int line) override {
    if (level < console_bridge::CONSOLE_BRIDGE_LOG_WARN) {
      former_->log(text, level, file, line);
      return;
    }
    const std::string subject = Subject(text);
    {
      const std::lock_guard<std::mutex> lock(mutex_);
      if (printed_.insert(subject).second) former_->log(text, level, file, line);
    }
    report_(subject.c_str());
  }

 private:
  Report report_;
  console_bridge::OutputHandler* former_;
  std::mutex mutex_;
  std::set<std::string> printed_;  // by subject
};

}  // namespace

/// Prints further warnings of console_bridge once each, and reports each time that they come.
///
/// To be called once. `report` must stay valid until the process ends.
extern "C" void flatland_viz_print_warnings_once(Report report) {
  static OncePrinted handler(report, console_bridge::getOutputHandler());
  console_bridge::useOutputHandler(&handler);
}
