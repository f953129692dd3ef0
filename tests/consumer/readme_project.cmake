# SPDX-License-Identifier: MIT
# A new user's project, with nothing but what README.md says: its C++ and CMake blocks become main.cpp and CMakeLists.txt,
# the project is built against the installed package, meshes a CLI file and writes an INP file.
# cmake -DREADME=... -DDIRECTORY=... -DPREFIX=... -DSAMPLE=... -DGENERATOR=... -DCXX=... -DLAUNCHER=... [-DCOMPILED=...]
#   -P readme_project.cmake
# COMPILED is a library with the pipeline, as it is made with SLICE2MESH_SEPARATE: what takes longest is not compiled again.
# (That it can be, from the installed headers, is what consumer.package shows.)
cmake_minimum_required(VERSION 3.22)
include("${CMAKE_CURRENT_LIST_DIR}/../script_support.cmake")
file(READ "${README}" readme)
string(REPLACE ";" "@SEMICOLON@" readme "${readme}")
foreach(pair IN ITEMS "cpp main.cpp" "cmake CMakeLists.txt")
  string(REPLACE " " ";" pair "${pair}")
  list(GET pair 0 language)
  list(GET pair 1 name)
  string(FIND "${readme}" "```${language}\n" begin)
  if(begin EQUAL -1)
    message(FATAL_ERROR "README.md has no block of ${language}")
  endif()
  string(SUBSTRING "${readme}" ${begin} -1 block)
  string(REGEX REPLACE "^```[a-z]+\n" "" block "${block}")
  string(FIND "${block}" "\n```" end)
  string(SUBSTRING "${block}" 0 ${end} block)
  string(REPLACE "@SEMICOLON@" ";" block "${block}")
  file(CONFIGURE OUTPUT "${DIRECTORY}/${name}" CONTENT "${block}\n" @ONLY NEWLINE_STYLE UNIX)
endforeach()

set(options "")
if(COMPILED)
  set(options -DCMAKE_CXX_FLAGS=-DSLICE2MESH_SEPARATE "-DCMAKE_CXX_STANDARD_LIBRARIES=${COMPILED} -lmpfr -lgmp")
endif()
file(REMOVE_RECURSE "${DIRECTORY}/build")
run_or_fail(WORKING_DIRECTORY "${DIRECTORY}" "${CMAKE_COMMAND}" -S . -B build -G "${GENERATOR}" "-DCMAKE_PREFIX_PATH=${PREFIX}"
            "-DCMAKE_CXX_COMPILER=${CXX}" -DCMAKE_BUILD_TYPE=Plain "-DCMAKE_CXX_COMPILER_LAUNCHER=${LAUNCHER}"
            ${options})
run_or_fail(WORKING_DIRECTORY "${DIRECTORY}" "${CMAKE_COMMAND}" --build build)
file(REMOVE "${DIRECTORY}/part.inp")
run_or_fail(WORKING_DIRECTORY "${DIRECTORY}" build/my_part "${SAMPLE}" part.inp)
if(NOT output MATCHES "[1-9][0-9]* tets in 24 slabs, certified")
  message(FATAL_ERROR "my_part says: ${output}")
endif()
file(STRINGS "${DIRECTORY}/part.inp" elements REGEX "^\\*ELEMENT, *TYPE=C3D4")
if(NOT elements)
  message(FATAL_ERROR "part.inp has no elements")
endif()
