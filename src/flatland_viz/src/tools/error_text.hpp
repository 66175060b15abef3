#pragma once

/// The errors of flatland_server's services, for display.

#include <string>

namespace flatland_viz {

/// `message` of a response, without the name of the exception class that it begins with, which is
/// for programs: "ModelError: there is no model" becomes "there is no model".
std::string ErrorText(const std::string& message);

}  // namespace flatland_viz
