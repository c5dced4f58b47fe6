// SPDX-License-Identifier: MIT
// Messages of ROS 2 with numbers: commands and scale signals.
#pragma once
#include <geometry_msgs/msg/twist.hpp>
#include <geometry_msgs/msg/twist_stamped.hpp>
#include <geometry_msgs/msg/wrench.hpp>
#include <geometry_msgs/msg/wrench_stamped.hpp>
#include <sensor_msgs/msg/joint_state.hpp>
#include <sensor_msgs/msg/joy.hpp>
#include <std_msgs/msg/float32.hpp>
#include <std_msgs/msg/float32_multi_array.hpp>
#include <std_msgs/msg/float64.hpp>
#include <std_msgs/msg/float64_multi_array.hpp>

#include "seatrial_ros/number_messages.hpp"

namespace seatrial::ros {

struct Messages {
  using Joy = sensor_msgs::msg::Joy;
  using Wrench = geometry_msgs::msg::Wrench;
  using WrenchStamped = geometry_msgs::msg::WrenchStamped;
  using Twist = geometry_msgs::msg::Twist;
  using TwistStamped = geometry_msgs::msg::TwistStamped;
  using JointState = sensor_msgs::msg::JointState;
  using Float32MultiArray = std_msgs::msg::Float32MultiArray;
  using Float64MultiArray = std_msgs::msg::Float64MultiArray;
  using Float32 = std_msgs::msg::Float32;
  using Float64 = std_msgs::msg::Float64;
};

}  // namespace seatrial::ros
