// SPDX-License-Identifier: MIT
// How a node is going, for diagnostic_msgs of either ROS.
#pragma once
#include <string>
#include <utility>
#include <vector>

namespace seatrial::ros {

/// Level, message and values of diagnostic_msgs/DiagnosticStatus.
struct Diagnosis {
  enum Level : unsigned char { kOk = 0, kWarn = 1, kError = 2 };
  Level level = kOk;
  std::string message;
  std::vector<std::pair<std::string, std::string>> values;
};

}  // namespace seatrial::ros
