// SPDX-License-Identifier: MIT
// Headers of the library, and CGAL, which the target brings in.
#include <CGAL/version.h>
#include <slice2mesh/cli/write_cli.hpp>
#include <slice2mesh/pipeline/options.hpp>
#include <slice2mesh/version.hpp>

#include <cstdio>
#include <sstream>

int main() {
  slice2mesh::SliceStack stack;
  stack.layers.resize(1);
  std::ostringstream text;
  slice2mesh::write_cli(text, stack);
  std::printf("slice2mesh %s, CGAL %s\n", SLICE2MESH_VERSION, CGAL_VERSION_STR);
  return slice2mesh::Options{}.slabs.lump == 1 && !text.str().empty() ? 0 : 1;
}
