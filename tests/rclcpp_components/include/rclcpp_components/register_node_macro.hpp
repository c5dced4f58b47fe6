// SPDX-License-Identifier: MIT
// A stand-in: classes are kept by their names with what makes one, as a component container needs
// it.
#pragma once
#include <functional>
#include <map>
#include <memory>
#include <rclcpp/rclcpp.hpp>
#include <string>

namespace rclcpp_components {

using Make = std::function<std::shared_ptr<rclcpp::Node>(const rclcpp::NodeOptions&)>;

inline std::map<std::string, Make>& registered() {
  static std::map<std::string, Make> all;
  return all;
}

struct Registration {
  Registration(const std::string& name, Make make) { registered()[name] = std::move(make); }
};

}  // namespace rclcpp_components

// the counter: one name each, should several nodes be compiled as one file
#define REGISTRATION_NAMED(Class, number)                                               \
  static const rclcpp_components::Registration registration_##number{                   \
      #Class, [](const rclcpp::NodeOptions& options) -> std::shared_ptr<rclcpp::Node> { \
        return std::make_shared<Class>(options);                                        \
      }};
#define REGISTRATION_NUMBERED(Class, number) REGISTRATION_NAMED(Class, number)
#define RCLCPP_COMPONENTS_REGISTER_NODE(Class) REGISTRATION_NUMBERED(Class, __COUNTER__)
