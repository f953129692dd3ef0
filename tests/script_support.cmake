# SPDX-License-Identifier: MIT
# What the test scripts (cmake -P) share: include("${CMAKE_CURRENT_LIST_DIR}/../script_support.cmake").

# run_or_fail([WORKING_DIRECTORY <directory>] <command>...): what it prints becomes `output`; a code other than 0 is the end.
function(run_or_fail)
  cmake_parse_arguments(PARSE_ARGV 0 run "" "WORKING_DIRECTORY" "")
  if(NOT run_WORKING_DIRECTORY)
    set(run_WORKING_DIRECTORY "${CMAKE_CURRENT_BINARY_DIR}")
  endif()
  execute_process(COMMAND ${run_UNPARSED_ARGUMENTS} WORKING_DIRECTORY "${run_WORKING_DIRECTORY}" RESULT_VARIABLE result
                  OUTPUT_VARIABLE output ERROR_VARIABLE output)
  if(NOT result EQUAL 0)
    list(JOIN run_UNPARSED_ARGUMENTS " " command)
    message("${output}")
    message(FATAL_ERROR "failed (${result}): ${command}")
  endif()
  set(output "${output}" PARENT_SCOPE)
endfunction()

# check(<text> <condition>...): the end with that text where the condition does not hold; `out` and `err` are shown.
function(check text)
  if(NOT (${ARGN}))
    message(FATAL_ERROR "not so: ${text}\n--- standard output ---\n${out}\n--- standard error ---\n${err}")
  endif()
endfunction()

# run_program(<expected exit code> <arguments>...): runs PROGRAM in DIRECTORY; sets `code`, `out` and `err`.
macro(run_program expected)
  execute_process(COMMAND "${PROGRAM}" ${ARGN} WORKING_DIRECTORY "${DIRECTORY}" RESULT_VARIABLE code OUTPUT_VARIABLE out
                  ERROR_VARIABLE err)
  check("exit code ${expected} (is ${code}) of: slice2mesh ${ARGN}" "${code}" STREQUAL "${expected}")
endmacro()

# make_sample(<arguments>...): runs the example of that name in DIRECTORY.
function(make_sample)
  run_or_fail(WORKING_DIRECTORY "${DIRECTORY}" "${MAKE_SAMPLE}" ${ARGN})
endfunction()
