// SPDX-License-Identifier: MIT
// Any bytes either give a typed error or a stack that is written and read back as the same stack.
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <sstream>
#include <string_view>

#include "slice2mesh/cli/read_cli.hpp"
#include "slice2mesh/cli/write_cli.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size);

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  slice2mesh::SliceStack stack;
  try {
    stack = slice2mesh::parse_cli(std::string_view(reinterpret_cast<const char*>(data), size));
  } catch (const slice2mesh::Error&) {
    return 0;
  }
  if (stack.z_unit != stack.unit) return 0;  // a file has one unit: heights are converted and may be rounded
  std::stringstream file;
  slice2mesh::CliWriteOptions exact;
  exact.exact = true;
  try {
    slice2mesh::write_cli(file, stack, exact);
  } catch (const slice2mesh::Error&) {
    return 0;  // a text file cannot say everything that CLI+ parameters may do
  }
  const slice2mesh::SliceStack again = slice2mesh::read_cli(file, slice2mesh::CliReadOptions::as_written());
  if (!(again == stack)) std::abort();
  return 0;
}
