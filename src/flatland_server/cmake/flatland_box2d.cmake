# flatland_find_box2d(): finds Box2D 2.4, or builds it. Afterwards there is the target box2d::box2d.
#
#   -DFLATLAND_BOX2D=auto      the system's if it is 2.4, else built from source (the default)
#                    system    the system's, or an error
#                    source    built from source: static, within the extension module
#
# The source is upstream's 2.4.1, cloned by git. Without a network, -DFETCHCONTENT_SOURCE_DIR_BOX2D=FOLDER names a
# folder that has it already.
#
# Included by the core, and by each package that finds flatland_server with catkin.

set(FLATLAND_BOX2D auto CACHE STRING "Where Box2D comes from: auto, system or source")
set_property(CACHE FLATLAND_BOX2D PROPERTY STRINGS auto system source)

# Adds Box2D 2.4.1 as a static library with hidden symbols, without its programs and installation.
function(flatland_add_box2d)
  set(repository https://github.com/erincatto/box2d.git)
  set(commit 9ebbbcd960ad424e03e5de6e66a40764c16f51bc) # v2.4.1

  if(FETCHCONTENT_SOURCE_DIR_BOX2D)
    if(NOT EXISTS ${FETCHCONTENT_SOURCE_DIR_BOX2D}/include/box2d/box2d.h)
      message(FATAL_ERROR "FETCHCONTENT_SOURCE_DIR_BOX2D: expected the source of Box2D 2.4.1, found no "
        "include/box2d/box2d.h in ${FETCHCONTENT_SOURCE_DIR_BOX2D}")
    endif()
  elseif(NOT FETCHCONTENT_FULLY_DISCONNECTED AND NOT FLATLAND_BOX2D_FETCHED)
    set(alternatives "Or install Box2D 2.4 (Debian 12, Ubuntu 22.04: apt-get install libbox2d-dev), or unpack its "
      "source and pass -DFETCHCONTENT_SOURCE_DIR_BOX2D=FOLDER (pip: "
      "pip install . -C cmake.define.FETCHCONTENT_SOURCE_DIR_BOX2D=FOLDER).")
    string(CONCAT alternatives ${alternatives})
    find_package(Git QUIET)
    if(NOT GIT_FOUND)
      message(FATAL_ERROR "Box2D has to be built from source, and there is no git to fetch it: install git. "
        ${alternatives})
    endif()
    execute_process(COMMAND ${CMAKE_COMMAND} -E env GIT_TERMINAL_PROMPT=0 ${GIT_EXECUTABLE} ls-remote ${repository} HEAD
      TIMEOUT 60 RESULT_VARIABLE status OUTPUT_QUIET ERROR_VARIABLE reason ERROR_STRIP_TRAILING_WHITESPACE)
    if(NOT status EQUAL 0)
      message(FATAL_ERROR "Box2D has to be built from source, and ${repository} cannot be reached: ${reason}\n"
        ${alternatives})
    endif()
  endif()

  # Box2D's CMakeLists.txt is of CMake 3.8: variables count as its options only by this policy (catkin
  # sets BUILD_SHARED_LIBS).
  set(CMAKE_POLICY_DEFAULT_CMP0077 NEW)
  set(BUILD_SHARED_LIBS OFF)
  set(BOX2D_BUILD_UNIT_TESTS OFF)
  set(BOX2D_BUILD_TESTBED OFF)
  set(BOX2D_BUILD_DOCS OFF)
  set(CMAKE_POSITION_INDEPENDENT_CODE ON)
  set(CMAKE_WARN_DEPRECATED OFF CACHE INTERNAL "Box2D asks for an old CMake")

  if(POLICY CMP0169)
    cmake_policy(SET CMP0169 OLD) # FetchContent_MakeAvailable can leave out the installation from CMake 3.28 on
  endif()
  include(FetchContent)
  FetchContent_Declare(box2d GIT_REPOSITORY ${repository} GIT_TAG ${commit})
  FetchContent_GetProperties(box2d)
  if(NOT box2d_POPULATED)
    FetchContent_Populate(box2d)
    add_subdirectory(${box2d_SOURCE_DIR} ${box2d_BINARY_DIR} EXCLUDE_FROM_ALL)
  endif()
  set(FLATLAND_BOX2D_FETCHED ON CACHE INTERNAL "Box2D's source is there")
  set(FLATLAND_BOX2D_LICENSE ${box2d_SOURCE_DIR}/LICENSE CACHE INTERNAL "of the Box2D in the extension module")
  target_include_directories(box2d SYSTEM INTERFACE ${box2d_SOURCE_DIR}/include)
  # Another module of the process may have a Box2D of its own.
  target_link_options(box2d INTERFACE LINKER:--exclude-libs,ALL)
  add_library(box2d::box2d ALIAS box2d)
endfunction()

function(flatland_find_box2d)
  if(NOT FLATLAND_BOX2D MATCHES "^(auto|system|source)$")
    message(FATAL_ERROR "FLATLAND_BOX2D: expected auto, system or source, found \"${FLATLAND_BOX2D}\"")
  endif()
  if(TARGET box2d::box2d)
    return()
  endif()

  unset(FLATLAND_BOX2D_LICENSE CACHE)
  if(NOT FLATLAND_BOX2D STREQUAL source)
    find_package(box2d 2.4 CONFIG QUIET)
  endif()
  if(TARGET box2d::box2d)
    message(STATUS "Box2D ${box2d_VERSION}: ${box2d_DIR}")
  elseif(FLATLAND_BOX2D STREQUAL system)
    set(found ${box2d_CONSIDERED_VERSIONS})
    if(NOT found)
      set(found none)
    endif()
    message(FATAL_ERROR "FLATLAND_BOX2D=system: expected Box2D 2.4 with its CMake files, found ${found}. Install it "
      "(Debian 12, Ubuntu 22.04: apt-get install libbox2d-dev), or have it built with FLATLAND_BOX2D=auto.")
  else()
    message(STATUS "Box2D 2.4.1: built from source")
    flatland_add_box2d()
  endif()
endfunction()
