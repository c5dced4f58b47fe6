// SPDX-License-Identifier: MIT
// The messages of ROS 2 that are exchanged, with its names and members. `each` visits the members
// in the order of their definition, which is that on the wire.
#pragma once
#include <array>
#include <cstdint>
#include <string>
#include <vector>

namespace builtin_interfaces::msg {

struct Time {
  std::int32_t sec = 0;
  std::uint32_t nanosec = 0;

  template <class Visit>
  void each(Visit visit) {
    visit("sec", sec);
    visit("nanosec", nanosec);
  }
};

}  // namespace builtin_interfaces::msg

namespace std_msgs::msg {

struct Header {
  builtin_interfaces::msg::Time stamp;
  std::string frame_id;

  template <class Visit>
  void each(Visit visit) {
    visit("stamp", stamp);
    visit("frame_id", frame_id);
  }
};

}  // namespace std_msgs::msg

namespace geometry_msgs::msg {

/// Also geometry_msgs/Point, which has the same members.
struct Vector3 {
  double x = 0.0;
  double y = 0.0;
  double z = 0.0;

  template <class Visit>
  void each(Visit visit) {
    visit("x", x);
    visit("y", y);
    visit("z", z);
  }
};

struct Quaternion {
  double x = 0.0;
  double y = 0.0;
  double z = 0.0;
  double w = 1.0;

  template <class Visit>
  void each(Visit visit) {
    visit("x", x);
    visit("y", y);
    visit("z", z);
    visit("w", w);
  }
};

struct Pose {
  Vector3 position;
  Quaternion orientation;

  template <class Visit>
  void each(Visit visit) {
    visit("position", position);
    visit("orientation", orientation);
  }
};

struct PoseStamped {
  static constexpr const char* kType = "geometry_msgs::msg::dds_::PoseStamped_";
  std_msgs::msg::Header header;
  Pose pose;

  template <class Visit>
  void each(Visit visit) {
    visit("header", header);
    visit("pose", pose);
  }
};

struct PoseWithCovariance {
  Pose pose;
  std::array<double, 36> covariance = {};

  template <class Visit>
  void each(Visit visit) {
    visit("pose", pose);
    visit("covariance", covariance);
  }
};

struct Twist {
  Vector3 linear;
  Vector3 angular;

  template <class Visit>
  void each(Visit visit) {
    visit("linear", linear);
    visit("angular", angular);
  }
};

struct TwistWithCovariance {
  Twist twist;
  std::array<double, 36> covariance = {};

  template <class Visit>
  void each(Visit visit) {
    visit("twist", twist);
    visit("covariance", covariance);
  }
};

}  // namespace geometry_msgs::msg

namespace nav_msgs::msg {

struct Odometry {
  static constexpr const char* kType = "nav_msgs::msg::dds_::Odometry_";
  std_msgs::msg::Header header;
  std::string child_frame_id;
  geometry_msgs::msg::PoseWithCovariance pose;
  geometry_msgs::msg::TwistWithCovariance twist;

  template <class Visit>
  void each(Visit visit) {
    visit("header", header);
    visit("child_frame_id", child_frame_id);
    visit("pose", pose);
    visit("twist", twist);
  }
};

}  // namespace nav_msgs::msg

namespace sensor_msgs::msg {

struct Joy {
  static constexpr const char* kType = "sensor_msgs::msg::dds_::Joy_";
  std_msgs::msg::Header header;
  std::vector<float> axes;
  std::vector<std::int32_t> buttons;

  template <class Visit>
  void each(Visit visit) {
    visit("header", header);
    visit("axes", axes);
    visit("buttons", buttons);
  }
};

}  // namespace sensor_msgs::msg
