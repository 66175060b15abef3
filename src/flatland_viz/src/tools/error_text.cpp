#include "error_text.hpp"

#include <cctype>

namespace flatland_viz {

namespace {

const std::string kSuffix = "Error";

bool IsClassName(const std::string& word) {
  for (const unsigned char character : word) {
    if (!std::isalpha(character) && character != '_') {
      return false;
    }
  }
  return word.size() > kSuffix.size() &&
         word.compare(word.size() - kSuffix.size(), kSuffix.size(), kSuffix) == 0;
}

}  // namespace

std::string ErrorText(const std::string& message) {
  const std::string separator = ": ";
  const auto end = message.find(separator);
  const bool has_name = end != std::string::npos && IsClassName(message.substr(0, end));
  return has_name ? message.substr(end + separator.size()) : message;
}

}  // namespace flatland_viz
