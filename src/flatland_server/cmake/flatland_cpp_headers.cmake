# Headers of the original Flatland's names, for packages with C++ plugins: a build ends with a hint.

set(guide "docs/coming_from_cpp.md")
foreach(header flatland_plugin model_plugin world_plugin plugin_manager)
  list(APPEND plugin_headers flatland_server/${header})
endforeach()
foreach(header bumper bool_sensor diff_drive dynamics_limits gps laser model_tf_publisher simple tricycle_drive tween
    update_timer)
  list(APPEND plugin_headers flatland_plugins/${header})
endforeach()
foreach(header ${plugin_headers})
  file(GENERATE OUTPUT ${CATKIN_DEVEL_PREFIX}/include/${header}.h
    CONTENT "#error \"This Flatland runs plugins in Python: ${guide} says how to port one in C++\"\n")
endforeach()

# What nodes include, too.
foreach(header geometry layer model model_body timekeeper types world yaml_preprocessor yaml_reader body entity exceptions
    joint collision_filter_registry debug_visualization)
  file(GENERATE OUTPUT ${CATKIN_DEVEL_PREFIX}/include/flatland_server/${header}.h
    CONTENT "#error \"This Flatland has no C++ library: a node needs its messages and services alone, ${guide} says what a plugin needs\"\n")
endforeach()
install(DIRECTORY ${CATKIN_DEVEL_PREFIX}/include/flatland_server ${CATKIN_DEVEL_PREFIX}/include/flatland_plugins
  DESTINATION ${CATKIN_GLOBAL_INCLUDE_DESTINATION})
