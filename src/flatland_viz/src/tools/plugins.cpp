/// Exports the tools, the view and the display to rviz; plugin_description.xml has their names.

#include <pluginlib/class_list_macros.hpp>

#include "interact_tool.hpp"
#include "map_view.hpp"
#include "measure_tool.hpp"
#include "models_display.hpp"
#include "pause_sim_tool.hpp"
#include "spawn_model_tool.hpp"

PLUGINLIB_EXPORT_CLASS(flatland_viz::InteractTool, rviz::Tool)
PLUGINLIB_EXPORT_CLASS(flatland_viz::MapView, rviz::ViewController)
PLUGINLIB_EXPORT_CLASS(flatland_viz::MeasureTool, rviz::Tool)
PLUGINLIB_EXPORT_CLASS(flatland_viz::ModelsDisplay, rviz::Display)
PLUGINLIB_EXPORT_CLASS(flatland_viz::PauseSimTool, rviz::Tool)
PLUGINLIB_EXPORT_CLASS(flatland_viz::SpawnModelTool, rviz::Tool)
