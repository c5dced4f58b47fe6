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

/// As diagnostic_msgs/DiagnosticArray of either ROS, but for its stamp.
template <class Array>
Array as_array(const Diagnosis& found, const std::string& name) {
  Array message;
  auto& status = message.status.emplace_back();
  status.name = name;
  status.hardware_id = "seatrial";
  status.level = found.level;
  status.message = found.message;
  for (const auto& [key, value] : found.values) {
    auto& pair = status.values.emplace_back();
    pair.key = key;
    pair.value = value;
  }
  return message;
}

}  // namespace seatrial::ros
