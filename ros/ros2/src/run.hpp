// SPDX-License-Identifier: MIT
#pragma once
#include <string>

namespace seatrial_odometry {

/// Runs the node of this name until it ends. On what it can't do: one line, and exit code 1.
int run(const std::string& name, int argc, char** argv);

}  // namespace seatrial_odometry
