#include "error_text.hpp"

#include <regex>

namespace flatland_viz {

std::string ErrorText(const std::string& message) {
  static const std::regex class_name("^[A-Za-z_]+Error: ");
  return std::regex_replace(message, class_name, "", std::regex_constants::format_first_only);
}

}  // namespace flatland_viz
