// SPDX-License-Identifier: MIT
// Messages of ROS 1 with numbers: commands and scale signals.
#pragma once
#include <geometry_msgs/TwistStamped.h>
#include <geometry_msgs/WrenchStamped.h>
#include <sensor_msgs/JointState.h>
#include <sensor_msgs/Joy.h>
#include <std_msgs/Float32.h>
#include <std_msgs/Float32MultiArray.h>
#include <std_msgs/Float64.h>
#include <std_msgs/Float64MultiArray.h>

#include "seatrial_ros/number_messages.hpp"

namespace seatrial::ros {

struct Messages {
  using Joy = sensor_msgs::Joy;
  using Wrench = geometry_msgs::Wrench;
  using WrenchStamped = geometry_msgs::WrenchStamped;
  using Twist = geometry_msgs::Twist;
  using TwistStamped = geometry_msgs::TwistStamped;
  using JointState = sensor_msgs::JointState;
  using Float32MultiArray = std_msgs::Float32MultiArray;
  using Float64MultiArray = std_msgs::Float64MultiArray;
  using Float32 = std_msgs::Float32;
  using Float64 = std_msgs::Float64;
};

}  // namespace seatrial::ros
