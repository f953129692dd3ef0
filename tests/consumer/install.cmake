# SPDX-License-Identifier: MIT
# Installs headers and package files of the build tree BUILD_DIR into PREFIX, which is emptied first.
file(REMOVE_RECURSE "${PREFIX}")
execute_process(COMMAND "${CMAKE_COMMAND}" --install "${BUILD_DIR}" --prefix "${PREFIX}" --component development
                        --config "${CONFIG}" RESULT_VARIABLE result)
if(NOT result EQUAL 0)
  message(FATAL_ERROR "installing failed")
endif()
file(GLOB_RECURSE configuration "${PREFIX}/*/slice2meshConfig.cmake")
if(NOT configuration OR NOT EXISTS "${PREFIX}/include/slice2mesh/version.hpp")
  message(FATAL_ERROR "the installed tree is not complete")
endif()
