// SPDX-License-Identifier: MIT
// Messages of ROS 2 by its names and members, without ROS.
#pragma once
#include <array>
#include <cstdint>
#include <string>

namespace builtin_interfaces::msg {

struct Time {
  std::int32_t sec = 0;
  std::uint32_t nanosec = 0;
};

}  // namespace builtin_interfaces::msg

namespace std_msgs::msg {

struct Header {
  builtin_interfaces::msg::Time stamp;
  std::string frame_id;
};

}  // namespace std_msgs::msg

namespace geometry_msgs::msg {

/// Also geometry_msgs/Point, which has the same members.
struct Vector3 {
  double x = 0.0;
  double y = 0.0;
  double z = 0.0;
};

struct Quaternion {
  double x = 0.0;
  double y = 0.0;
  double z = 0.0;
  double w = 1.0;
};

struct Pose {
  Vector3 position;
  Quaternion orientation;
};

struct PoseWithCovariance {
  Pose pose;
  std::array<double, 36> covariance = {};
};

struct Twist {
  Vector3 linear;
  Vector3 angular;
};

struct TwistWithCovariance {
  Twist twist;
  std::array<double, 36> covariance = {};
};

}  // namespace geometry_msgs::msg

namespace nav_msgs::msg {

struct Odometry {
  std_msgs::msg::Header header;
  std::string child_frame_id;
  geometry_msgs::msg::PoseWithCovariance pose;
  geometry_msgs::msg::TwistWithCovariance twist;
};

}  // namespace nav_msgs::msg
