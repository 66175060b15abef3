# Headers of the original Flatland's names, for packages with C++ plugins: a build ends with a hint.

set(text "#error \"This Flatland runs plugins in Python: docs/coming_from_cpp.md says how to port one in C++\"\n")
foreach(header flatland_plugin geometry layer model model_body model_plugin timekeeper types world world_plugin
    yaml_preprocessor yaml_reader body entity exceptions joint collision_filter_registry debug_visualization
    plugin_manager)
  file(GENERATE OUTPUT ${CATKIN_DEVEL_PREFIX}/include/flatland_server/${header}.h CONTENT ${text})
endforeach()
foreach(header bumper bool_sensor diff_drive dynamics_limits gps laser model_tf_publisher simple tricycle_drive tween
    update_timer)
  file(GENERATE OUTPUT ${CATKIN_DEVEL_PREFIX}/include/flatland_plugins/${header}.h CONTENT ${text})
endforeach()
install(DIRECTORY ${CATKIN_DEVEL_PREFIX}/include/flatland_server ${CATKIN_DEVEL_PREFIX}/include/flatland_plugins
  DESTINATION ${CATKIN_GLOBAL_INCLUDE_DESTINATION})
