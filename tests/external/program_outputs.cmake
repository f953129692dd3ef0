# SPDX-License-Identifier: MIT
# cmake -DPROGRAM=... -DMAKE_SAMPLE=... -DDIRECTORY=... -P program_outputs.cmake
# The options of the program for outputs, base plate and steps.
cmake_minimum_required(VERSION 3.22)
include("${CMAKE_CURRENT_LIST_DIR}/../script_support.cmake")
file(REMOVE_RECURSE "${DIRECTORY}")
file(MAKE_DIRECTORY "${DIRECTORY}")

function(check_contains file text)
  file(READ "${DIRECTORY}/${file}" content)
  string(FIND "${content}" "${text}" place)
  check("${file} has ${text}" place GREATER -1)
endfunction()

make_sample(sample.cli)

# Every -o is written, each with what the options say.
run_program(0 sample.cli --lump 4 --support-radius 0.1 --plate-thickness 2 --plate-margin 3 --plate-slabs 2 -o a.vtu -o a.pvd
            -o a.inp -o a.msh --steps --time-per-layer 5 --base-temperature 350 --layer-faces --report r.json -q)
check_contains(a.vtu activation_time)
check_contains(a.pvd "timestep=\"25\" part=\"0\" file=\"a_layers/layer_0008.vtu\"")
check_contains(a_steps.inp "*INCLUDE, INPUT=a.inp")
check_contains(a_steps.inp "BOTTOM_NODES, 11, 11, 350")
check_contains(a_steps.inp "0.5, 5\n")
check_contains(a_steps.inp "PLATE_NODES, 300")
check_contains(a.inp "*SURFACE, NAME=COVERED_0002")
check_contains(a.msh "\"layer_0001_base_plate\"")
check_contains(a.msh "\"covered_0008\"")
file(READ "${DIRECTORY}/r.json" report)
string(JSON slabs LENGTH "${report}" mesh slabs)
check("two slabs of the plate and six of the part, has ${slabs}" slabs EQUAL 8)
string(JSON kind GET "${report}" mesh regions 2 kind)
check("the last region is the plate, is ${kind}" kind STREQUAL "plate")
string(JSON layers LENGTH "${report}" estimates layers)
check("estimates for each slab, has ${layers}" layers EQUAL 8)
string(JSON measured GET "${report}" estimates layers 2 measured)
check("bundles are measured" measured)
string(JSON staircase GET "${report}" estimates staircase_volume)
check("there is a staircase, ${staircase}" staircase GREATER 1)
check("the estimates are printed" out MATCHES "staircase error" AND out MATCHES "volume loss")

# Quadratic elements, and sets left out.
run_program(0 sample.cli --lump 8 --quadratic --no-surfaces -o q.inp -o q.msh -q --no-finer-slices)
check_contains(q.inp "TYPE=C3D10")
file(STRINGS "${DIRECTORY}/q.msh" names REGEX "\"wall\"")
check("no surfaces" NOT names)

run_program(1 sample.cli --plate-thickness=x -o b.vtu)
run_program(1 sample.cli --plate-thickness 1 --plate-margin 0 -o b.vtu)
run_program(1 sample.cli --plate-shape round -o b.vtu)
run_program(1 sample.cli --time-per-layer=-1 -o b.vtu)
if(EXISTS "${DIRECTORY}/b.vtu")
  message(FATAL_ERROR "b.vtu must not exist")
endif()

# Exodus II where the program was built with netCDF; otherwise that is said before any work is done.
if(WITH_NETCDF)
  run_program(0 sample.cli --lump 8 -o c.exo -q)
  check_contains(c.exo "layer_0001_bracket")
else()
  run_program(1 sample.cli --lump 8 -o c.exo -q)
  check("netCDF is named" err MATCHES "netCDF")
endif()
