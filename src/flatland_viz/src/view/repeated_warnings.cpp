/// Warnings of tf2, which come with every transform that it ignores: hundreds a second.
///
/// They come on any thread, while console_bridge's lock is held. So Python polls their numbers. A
/// call into Python from here could deadlock: it would wait for the GIL, while a thread with the
/// GIL waits for that lock, to print a warning of its own.

#include <console_bridge/console.h>

#include <algorithm>
#include <mutex>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace {

/// Frames' names come from other programs: of any length, and as many as they like.
constexpr std::size_t kMostSubjects = 100;
constexpr std::size_t kLongestSubject = 500;  // bytes
const char kOthers[] = "further warnings, each with another text";

/// The part of a warning that is the same when it comes again: without its time.
std::string Subject(const std::string& text) {
  return text.substr(0, std::min(text.find(" at time "), kLongestSubject));
}

struct Warning {
  std::string subject;
  int times;  // since it was taken
};

/// Prints each warning once, and counts all of them.
class OncePrinted : public console_bridge::OutputHandler {
 public:
  explicit OncePrinted(console_bridge::OutputHandler* former) : former_(former) {}

  void log(const std::string& text, console_bridge::LogLevel level, const char* file,
           int line) override {
    if (level < console_bridge::CONSOLE_BRIDGE_LOG_WARN || Count(Subject(text))) {
      former_->log(text, level, file, line);
    }
  }

  /// A subject by its number, and how often it has come since it was taken. Null beyond the last.
  std::optional<Warning> Take(std::size_t number) {
    const std::lock_guard<std::mutex> lock(mutex_);
    if (number >= warnings_.size()) return std::nullopt;
    Warning& warning = warnings_[number];
    return Warning{warning.subject, std::exchange(warning.times, 0)};
  }

 private:
  /// Returns true for a new subject.
  bool Count(const std::string& subject) {
    const std::lock_guard<std::mutex> lock(mutex_);
    const auto is_it = [&](const Warning& each) { return each.subject == subject; };
    auto found = std::find_if(warnings_.begin(), warnings_.end(), is_it);
    if (found == warnings_.end() && warnings_.size() > kMostSubjects) --found;  // the others
    if (found != warnings_.end()) return ++found->times, false;
    warnings_.push_back({warnings_.size() < kMostSubjects ? subject : kOthers, 1});
    return true;
  }

  console_bridge::OutputHandler* former_;
  std::mutex mutex_;
  std::vector<Warning> warnings_;  // up to `kMostSubjects`, then those others
};

OncePrinted& Handler() {
  static auto* const handler = new OncePrinted(console_bridge::getOutputHandler());
  return *handler;  // never deleted: threads warn until the process ends
}

}  // namespace

/// Prints further warnings of console_bridge once each, and counts them.
extern "C" void flatland_viz_print_warnings_once() { console_bridge::useOutputHandler(&Handler()); }

/// Takes a warning by its number, from 0 on: writes its text, cut to `size` bytes with the final
/// zero, and returns how often it has come since it was taken; -1 beyond the last one.
extern "C" int flatland_viz_take_warning(int number, char* text, int size) {
  const std::optional<Warning> warning = Handler().Take(number);
  if (!warning) return -1;
  text[warning->subject.copy(text, size - 1)] = '\0';
  return warning->times;
}
