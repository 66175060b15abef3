/// Exports the tools to rviz; plugin_description.xml has their names.

#include <pluginlib/class_list_macros.hpp>

#include "change_rate_tool.hpp"
#include "pause_sim_tool.hpp"
#include "spawn_model_tool.hpp"

PLUGINLIB_EXPORT_CLASS(flatland_viz::ChangeRateTool, rviz::Tool)
PLUGINLIB_EXPORT_CLASS(flatland_viz::PauseSimTool, rviz::Tool)
PLUGINLIB_EXPORT_CLASS(flatland_viz::SpawnModelTool, rviz::Tool)
