// SPDX-License-Identifier: MIT
// A node's diagnosis as a message of ROS 1.
#pragma once
#include <diagnostic_msgs/DiagnosticArray.h>
#include <ros/ros.h>

#include "seatrial_ros/diagnosis.hpp"

namespace seatrial::ros {

/// Named as diagnostic_updater names it: by the node's name without the first slash.
inline diagnostic_msgs::DiagnosticArray diagnostics(const Diagnosis& found,
                                                    const std::string& what) {
  auto message = as_array<diagnostic_msgs::DiagnosticArray>(
      found, ::ros::this_node::getName().substr(1) + ": " + what);
  message.header.stamp = ::ros::Time::now();
  return message;
}

}  // namespace seatrial::ros
