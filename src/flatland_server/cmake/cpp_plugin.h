// In place of a header of the C++ Flatland, for packages of plugins that include it.
#error "This Flatland runs plugins written in Python: docs/coming_from_cpp.md says how to port this one."
