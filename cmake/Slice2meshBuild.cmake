# SPDX-License-Identifier: MIT
# How the project's own programs and tests are compiled. Nothing here reaches those who only use the library.

if(SLICE2MESH_CCACHE AND NOT CMAKE_CXX_COMPILER_LAUNCHER)
  find_program(SLICE2MESH_CCACHE_PROGRAM ccache)
  mark_as_advanced(SLICE2MESH_CCACHE_PROGRAM)
  if(SLICE2MESH_CCACHE_PROGRAM)
    # The sloppiness is what ccache asks for with precompiled headers.
    set(CMAKE_CXX_COMPILER_LAUNCHER
        "${CMAKE_COMMAND};-E;env;CCACHE_SLOPPINESS=pch_defines,time_macros;${SLICE2MESH_CCACHE_PROGRAM}")
  endif()
endif()

set(slice2mesh_warnings "")
if(CMAKE_CXX_COMPILER_ID MATCHES "GNU|Clang")
  set(slice2mesh_warnings -Wall -Wextra -Wpedantic -Wshadow -Wconversion -Wsign-conversion)
  if(SLICE2MESH_WERROR)
    list(APPEND slice2mesh_warnings -Werror)
  endif()
elseif(MSVC)
  set(slice2mesh_warnings /W4)
  if(SLICE2MESH_WERROR)
    list(APPEND slice2mesh_warnings /WX)
  endif()
endif()

# Strict floating point: certificates and exact predicates rely on it. Refuse what would break it silently.
string(TOUPPER "${CMAKE_BUILD_TYPE}" slice2mesh_build_type)
if("${CMAKE_CXX_FLAGS} ${CMAKE_CXX_FLAGS_${slice2mesh_build_type}}" MATCHES "-ffast-math|-Ofast|-funsafe-math")
  message(FATAL_ERROR "slice2mesh must not be compiled with -ffast-math, -funsafe-math-optimizations or -Ofast")
endif()

# Settings of one of our own programs, tests or examples.
function(slice2mesh_own_target target)
  target_compile_options(${target} PRIVATE ${slice2mesh_warnings})
  if(CMAKE_CXX_COMPILER_ID MATCHES "GNU|Clang")
    # Nothing reads errno after a square root: without it, that is one instruction, with the same result.
    target_compile_options(${target} PRIVATE -fno-math-errno)
  endif()
  if(SLICE2MESH_SANITIZE)
    if(CMAKE_CXX_COMPILER_ID STREQUAL "GNU")
      # False alarms of GCC inside the standard library in instrumented code.
      target_compile_options(${target} PRIVATE -Wno-maybe-uninitialized)
    endif()
    # CGAL's arrangements cast faces to a class of their own that only adds functions.
    target_compile_options(${target} PRIVATE -fsanitize=${SLICE2MESH_SANITIZE} -fno-sanitize-recover=all
                                             -fno-sanitize=vptr -fno-omit-frame-pointer)
    target_link_options(${target} PRIVATE -fsanitize=${SLICE2MESH_SANITIZE})
  endif()
  set_target_properties(${target} PROPERTIES CXX_EXTENSIONS OFF)
endfunction()

# The same for a test, an example, or what of the program is not the pipeline.
function(slice2mesh_test_target target)
  slice2mesh_own_target(${target})
  separate_arguments(flags NATIVE_COMMAND "${SLICE2MESH_TEST_FLAGS}")
  target_compile_options(${target} PRIVATE ${flags})
endfunction()

# The same for one that has little to do itself: where flags are given so that it compiles faster, it is not optimized.
function(slice2mesh_light_target target)
  slice2mesh_test_target(${target})
  if(SLICE2MESH_TEST_FLAGS AND CMAKE_CXX_COMPILER_ID MATCHES "GNU|Clang")
    target_compile_options(${target} PRIVATE -O0)
  endif()
endfunction()
