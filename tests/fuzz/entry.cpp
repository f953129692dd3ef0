// SPDX-License-Identifier: MIT
// What libFuzzer calls; SLICE2MESH_FUZZ_TARGET is the function of targets.hpp.
#include "fuzz/targets.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size);

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  slice2mesh_fuzz::SLICE2MESH_FUZZ_TARGET(data, size);  // an exception that leaves it ends the fuzzer
  return 0;
}
