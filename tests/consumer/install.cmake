# SPDX-License-Identifier: MIT
# Installs headers and package files of the build tree BUILD_DIR into PREFIX, which is emptied first.
cmake_minimum_required(VERSION 3.22)
include("${CMAKE_CURRENT_LIST_DIR}/../script_support.cmake")
file(REMOVE_RECURSE "${PREFIX}")
run_or_fail("${CMAKE_COMMAND}" --install "${BUILD_DIR}" --prefix "${PREFIX}" --component development --config "${CONFIG}")
file(GLOB_RECURSE configuration "${PREFIX}/*/slice2meshConfig.cmake")
if(NOT configuration OR NOT EXISTS "${PREFIX}/include/slice2mesh/version.hpp")
  message(FATAL_ERROR "the installed tree is not complete")
endif()
