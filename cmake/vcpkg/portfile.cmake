# SPDX-License-Identifier: MIT
# A port that is a part of the repository: vcpkg install slice2mesh --overlay-ports=<repository>/cmake/vcpkg
# It builds the tree it lies in, so nothing is downloaded but the dependencies.
get_filename_component(SOURCE_PATH "${CMAKE_CURRENT_LIST_DIR}/../.." ABSOLUTE)

vcpkg_check_features(
  OUT_FEATURE_OPTIONS FEATURE_OPTIONS
  FEATURES program SLICE2MESH_BUILD_PROGRAM zlib SLICE2MESH_WITH_ZLIB netcdf SLICE2MESH_WITH_NETCDF
  INVERTED_FEATURES pipeline SLICE2MESH_CORE_ONLY)
if(NOT "program" IN_LIST FEATURES)
  set(VCPKG_BUILD_TYPE release) # headers only
endif()

vcpkg_cmake_configure(
  SOURCE_PATH "${SOURCE_PATH}"
  OPTIONS ${FEATURE_OPTIONS} -DSLICE2MESH_BUILD_TESTS=OFF -DSLICE2MESH_BUILD_EXAMPLES=OFF -DSLICE2MESH_BUILD_BENCHMARKS=OFF
          -DSLICE2MESH_WERROR=OFF -DSLICE2MESH_CCACHE=OFF -DSLICE2MESH_INSTALL=ON)
vcpkg_cmake_install()
vcpkg_cmake_config_fixup(CONFIG_PATH lib/cmake/slice2mesh)
if("program" IN_LIST FEATURES)
  vcpkg_copy_tools(TOOL_NAMES slice2mesh AUTO_CLEAN)
endif()
file(REMOVE_RECURSE "${CURRENT_PACKAGES_DIR}/debug" "${CURRENT_PACKAGES_DIR}/lib")
vcpkg_install_copyright(FILE_LIST "${SOURCE_PATH}/LICENSE")
