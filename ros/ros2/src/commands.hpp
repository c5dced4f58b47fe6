// SPDX-License-Identifier: MIT
// Commands as messages of ROS 2, of whatever type the vehicle says.
#pragma once
#include <functional>
#include <rclcpp/rclcpp.hpp>
#include <vector>

#include "seatrial_ros/command_writer.hpp"

namespace seatrial::ros {

/// Publishers of all topics of a vehicle's commands.
class CommandPublishers {
 public:
  CommandPublishers(rclcpp::Node& node, const std::vector<CommandTopic>& topics);

  void publish(const rclcpp::Time& now, const double* values) const;

 private:
  using Send = std::function<void(const rclcpp::Time&, const Numbers&)>;

  struct Outlet {
    const CommandTopic* topic;
    Send send;
  };

  std::vector<Outlet> outlets_;
};

}  // namespace seatrial::ros
