# SPDX-License-Identifier: MIT
# The C++ block of README.md is examples/one_call.cpp without its license line.
file(READ "${SOURCE_DIR}/README.md" readme)
file(READ "${SOURCE_DIR}/examples/one_call.cpp" example)
string(REGEX REPLACE "^// SPDX[^\n]*\n" "" example "${example}")
string(FIND "${readme}" "```cpp\n${example}```" position)
if(position EQUAL -1)
  message(FATAL_ERROR "README.md does not hold the text of examples/one_call.cpp")
endif()
