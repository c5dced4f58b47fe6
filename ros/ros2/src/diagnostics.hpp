// SPDX-License-Identifier: MIT
// A node's diagnosis as a message of ROS 2.
#pragma once
#include <diagnostic_msgs/msg/diagnostic_array.hpp>
#include <diagnostic_msgs/msg/diagnostic_status.hpp>
#include <diagnostic_msgs/msg/key_value.hpp>
#include <rclcpp/rclcpp.hpp>
#include <string>

#include "seatrial_ros/diagnosis.hpp"

namespace seatrial::ros {

/// Named as diagnostic_updater names it: by the node's name without its namespace.
inline diagnostic_msgs::msg::DiagnosticArray diagnostics(const rclcpp::Node& node,
                                                         const Diagnosis& found,
                                                         const std::string& what) {
  diagnostic_msgs::msg::DiagnosticStatus status;
  status.name = std::string(node.get_name()) + ": " + what;
  status.hardware_id = "seatrial";
  status.level = found.level;
  status.message = found.message;
  for (const auto& [key, value] : found.values) {
    diagnostic_msgs::msg::KeyValue pair;
    pair.key = key;
    pair.value = value;
    status.values.push_back(pair);
  }
  diagnostic_msgs::msg::DiagnosticArray message;
  message.header.stamp = node.now();
  message.status.push_back(status);
  return message;
}

}  // namespace seatrial::ros
