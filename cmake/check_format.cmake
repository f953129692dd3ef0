# SPDX-License-Identifier: MIT
# cmake -DCLANG_FORMAT=<program> -DSOURCE_DIR=<directory> -P check_format.cmake
# Fails and names the files whose layout is not that of .clang-format.
file(GLOB_RECURSE files "${SOURCE_DIR}/include/*.hpp" "${SOURCE_DIR}/src/*.[ch]pp" "${SOURCE_DIR}/examples/*.[ch]pp"
     "${SOURCE_DIR}/tests/*.[ch]pp" "${SOURCE_DIR}/benchmarks/*.[ch]pp")
if(NOT files)
  message(FATAL_ERROR "no sources found below ${SOURCE_DIR}")
endif()
execute_process(COMMAND "${CLANG_FORMAT}" --dry-run --Werror ${files} RESULT_VARIABLE result ERROR_VARIABLE messages)
if(NOT result EQUAL 0)
  string(REGEX MATCHALL "[^\n]+: error: [^\n]+" lines "${messages}")
  list(TRANSFORM lines REPLACE ":[0-9]+:[0-9]+:.*" "")
  list(REMOVE_DUPLICATES lines)
  list(JOIN lines "\n  " names)
  message(FATAL_ERROR "not laid out as .clang-format says (run clang-format -i on them):\n  ${names}\n")
endif()
