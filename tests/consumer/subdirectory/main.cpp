// SPDX-License-Identifier: MIT
#include <slice2mesh/slice2mesh.hpp>

int main() {
  return slice2mesh::Options{}.slabs.lump == 1 ? 0 : 1;
}
