#include "bodies_display.hpp"

#include <pluginlib/class_list_macros.hpp>

PLUGINLIB_EXPORT_CLASS(flatland_viz::BodiesDisplay, rviz::Display)
