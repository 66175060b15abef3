# flatland_devel_types(FOLDER ...): shows the types of Python packages in the devel space; after catkin_python_setup().
#
# There, a package is a relay of catkin's, in which type checkers and editors see no types. Links to the source are put
# beside it: NAME-stubs (PEP 561), and an __init__.pyi, which mypy reads before the relay.
#
# Included by each package that finds flatland_server with catkin.

function(flatland_devel_types)
  foreach(folder ${ARGN})
    set(source ${CMAKE_CURRENT_SOURCE_DIR}/${folder})
    get_filename_component(name ${folder} NAME)
    set(package ${CATKIN_DEVEL_PREFIX}/${CATKIN_GLOBAL_PYTHON_DESTINATION}/${name})
    execute_process(COMMAND ${CMAKE_COMMAND} -E create_symlink ${source} ${package}-stubs)
    execute_process(COMMAND ${CMAKE_COMMAND} -E create_symlink ${source}/__init__.py ${package}/__init__.pyi)
  endforeach()
endfunction()
