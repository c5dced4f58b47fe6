// SPDX-License-Identifier: MIT
#pragma once
#include <cstdio>
#include <stdexcept>

namespace seatrial::ros {

/// Runs a node until it ends. On what it can't do: one line, and exit code 1.
template <class Spin>
int run(const char* name, const Spin& spin) {
  try {
    spin();
  } catch (const std::runtime_error& error) {
    std::fprintf(stderr, "%s: %s\n", name, error.what());
    return 1;
  }
  return 0;
}

}  // namespace seatrial::ros
