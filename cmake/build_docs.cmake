# SPDX-License-Identifier: MIT
# cmake -DDOXYGEN=<program> -DDOXYFILE=<file> -DOUTPUT=<directory> [-DPYTHON=<program>] -P build_docs.cmake
# Runs Doxygen into an empty directory and fails on any warning, all of which are shown. (WARN_AS_ERROR of Doxygen would
# end with the first one.)
file(REMOVE_RECURSE "${OUTPUT}")
file(MAKE_DIRECTORY "${OUTPUT}")
execute_process(COMMAND "${DOXYGEN}" "${DOXYFILE}" RESULT_VARIABLE result OUTPUT_VARIABLE messages ERROR_VARIABLE messages)
string(STRIP "${messages}" messages)
if(NOT result EQUAL 0 OR NOT messages STREQUAL "")
  message("${messages}")
  message(FATAL_ERROR "Doxygen has something to say, see above")
endif()
# Nothing to complain about would also be said of nothing: the pages of what everybody uses must be there.
file(GLOB pages "${OUTPUT}/html/*.html")
list(LENGTH pages count)
foreach(page IN ITEMS index structslice2mesh_1_1Options slice__to__mesh_8hpp)
  if(NOT EXISTS "${OUTPUT}/html/${page}.html")
    message(FATAL_ERROR "the page ${page}.html was not made (${count} pages were)")
  endif()
endforeach()
if(PYTHON)
  execute_process(COMMAND "${PYTHON}" "${CMAKE_CURRENT_LIST_DIR}/../scripts/check_reference.py" "${OUTPUT}/xml"
                  RESULT_VARIABLE result)
  if(NOT result EQUAL 0)
    message(FATAL_ERROR "docstrings with gaps, see above")
  endif()
endif()
message(STATUS "${count} pages in ${OUTPUT}/html")
