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
  diagnostic_msgs::DiagnosticStatus status;
  status.name = ::ros::this_node::getName().substr(1) + ": " + what;
  status.hardware_id = "seatrial";
  status.level = found.level;
  status.message = found.message;
  for (const auto& [key, value] : found.values) {
    diagnostic_msgs::KeyValue pair;
    pair.key = key;
    pair.value = value;
    status.values.push_back(pair);
  }
  diagnostic_msgs::DiagnosticArray message;
  message.header.stamp = ::ros::Time::now();
  message.status.push_back(status);
  return message;
}

}  // namespace seatrial::ros
