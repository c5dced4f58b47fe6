// SPDX-License-Identifier: MIT
// A node's parameters, declared with what they are; read when it starts.
#pragma once
#include <rcl_interfaces/msg/floating_point_range.hpp>
#include <rcl_interfaces/msg/parameter_descriptor.hpp>
#include <rclcpp/rclcpp.hpp>

#include "seatrial_ros/settings.hpp"

namespace seatrial::ros {

template <class Given>
Given read_settings(rclcpp::Node& node) {
  Given settings;
  each_parameter(settings, [&node](const Parameter& p, auto& value) {
    rcl_interfaces::msg::ParameterDescriptor descriptor;
    descriptor.description = p.description;
    descriptor.read_only = true;
    if (p.low < p.high) {
      rcl_interfaces::msg::FloatingPointRange range;
      range.from_value = p.low;
      range.to_value = p.high;
      descriptor.floating_point_range.push_back(range);
    }
    value = node.declare_parameter(p.name, value, descriptor);
  });
  return settings;
}

}  // namespace seatrial::ros
