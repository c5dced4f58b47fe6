// SPDX-License-Identifier: MIT
#pragma once
#include <cstdio>
#include <exception>

namespace seatrial::ros {

/// Runs a node from ros::init to its end. On what it can't do: one line, and exit code 1.
template <class Spin>
int run(const char* name, const Spin& spin) {
  try {
    spin();
  } catch (const std::exception& error) {
    std::fprintf(stderr, "%s: %s\n", name, error.what());
    return 1;
  }
  return 0;
}

}  // namespace seatrial::ros
