// SPDX-License-Identifier: MIT
// A node's diagnosis as a message of ROS 2.
#pragma once
#include <diagnostic_msgs/msg/diagnostic_array.hpp>
#include <rclcpp/rclcpp.hpp>
#include <string>

#include "seatrial_ros/diagnosis.hpp"

namespace seatrial::ros {

/// Named as diagnostic_updater names it: by the node's name without its namespace.
inline diagnostic_msgs::msg::DiagnosticArray diagnostics(const rclcpp::Node& node,
                                                         const Diagnosis& found,
                                                         const std::string& what) {
  auto message = as_array<diagnostic_msgs::msg::DiagnosticArray>(
      found, std::string(node.get_name()) + ": " + what);
  message.header.stamp = node.now();
  return message;
}

}  // namespace seatrial::ros
