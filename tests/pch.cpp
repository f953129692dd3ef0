// SPDX-License-Identifier: MIT
// Empty: its target makes the precompiled header that the test programs use.
