// SPDX-License-Identifier: MIT
// A node's parameters, declared with what they are; read when it starts.
#pragma once
#include <rcl_interfaces/msg/floating_point_range.hpp>
#include <rcl_interfaces/msg/parameter_descriptor.hpp>
#include <rclcpp/rclcpp.hpp>
#include <stdexcept>
#include <string>
#include <type_traits>
#include <vector>

#include "seatrial_ros/settings.hpp"

namespace seatrial::ros {

namespace detail {

/// A given value as the parameter's type; whole numbers where numbers are expected, too.
template <class Value>
Value converted(const Parameter& p, const rclcpp::ParameterValue& given) {
  using rclcpp::ParameterType;
  constexpr bool number = std::is_same_v<Value, double>;
  constexpr bool list = std::is_same_v<Value, std::vector<double>>;
  if constexpr (number) {
    if (given.get_type() == ParameterType::PARAMETER_INTEGER) {
      return static_cast<double>(given.get<std::int64_t>());
    }
  }
  if constexpr (list) {
    if (given.get_type() == ParameterType::PARAMETER_INTEGER_ARRAY) {
      const auto& whole = given.get<std::vector<std::int64_t>>();
      return {whole.begin(), whole.end()};
    }
  }
  const rclcpp::ParameterValue own{Value()};
  if (given.get_type() != own.get_type()) {
    throw std::runtime_error("parameter " + std::string(p.name) + " is of type " +
                             rclcpp::to_string(given.get_type()) + "; expected " +
                             kind_of<Value>() + ": " + p.description);
  }
  return given.get<Value>();
}

}  // namespace detail

/// Throws std::runtime_error with one line where a value is of another type or out of its range.
template <class Given>
Given read_settings(rclcpp::Node& node) {
  Given settings;
  const auto& given = node.get_node_parameters_interface()->get_parameter_overrides();
  each_parameter(settings, [&node, &given](const Parameter& p, auto& value) {
    using Value = std::decay_t<decltype(value)>;
    const auto found = given.find(p.name);
    if (found != given.end()) value = detail::converted<Value>(p, found->second);
    rcl_interfaces::msg::ParameterDescriptor descriptor;
    descriptor.description = p.description;
    descriptor.read_only = true;
    if constexpr (std::is_same_v<Value, double>) {
      check_range(p, value);
      rcl_interfaces::msg::FloatingPointRange range;
      range.from_value = p.low;
      range.to_value = p.high;
      descriptor.floating_point_range.push_back(range);
    }
    // the given value is in `value` already
    node.declare_parameter(p.name, rclcpp::ParameterValue(value), descriptor, true);
  });
  return settings;
}

}  // namespace seatrial::ros
