# SPDX-License-Identifier: MIT
# Defines slice2mesh::tetgen where TetGen is found. TetGen is under the AGPL: so is, when it is distributed, what links to
# this target.
find_path(SLICE2MESH_TETGEN_INCLUDE_DIR tetgen.h)
find_library(SLICE2MESH_TETGEN_LIBRARY NAMES tet tetgen)
mark_as_advanced(SLICE2MESH_TETGEN_INCLUDE_DIR SLICE2MESH_TETGEN_LIBRARY)
if(SLICE2MESH_TETGEN_INCLUDE_DIR AND SLICE2MESH_TETGEN_LIBRARY AND NOT TARGET slice2mesh::tetgen)
  add_library(slice2mesh::tetgen INTERFACE IMPORTED GLOBAL)
  set_target_properties(slice2mesh::tetgen PROPERTIES INTERFACE_SYSTEM_INCLUDE_DIRECTORIES
                                                      "${SLICE2MESH_TETGEN_INCLUDE_DIR}")
  target_link_libraries(slice2mesh::tetgen INTERFACE slice2mesh::slice2mesh "${SLICE2MESH_TETGEN_LIBRARY}")
endif()
