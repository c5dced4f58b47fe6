// SPDX-License-Identifier: MIT
// Commands as messages of ROS 1, of whatever type the vehicle says.
#pragma once
#include <geometry_msgs/TwistStamped.h>
#include <geometry_msgs/WrenchStamped.h>
#include <ros/ros.h>
#include <sensor_msgs/JointState.h>
#include <sensor_msgs/Joy.h>
#include <std_msgs/Float64.h>
#include <std_msgs/Float64MultiArray.h>

#include <vector>

#include "seatrial_ros/command_writer.hpp"

namespace seatrial::ros {

/// Publishers of all topics of a vehicle's commands.
class CommandPublishers {
 public:
  CommandPublishers(::ros::NodeHandle& handle, const std::vector<CommandTopic>& topics)
      : topics_(&topics) {
    for (const CommandTopic& topic : topics) {
      with_type(topic.kind(), [this, &handle, &topic](auto message) {
        publishers_.push_back(handle.advertise<decltype(message)>(topic.name(), kQueue));
      });
    }
  }

  void publish(const ::ros::Time& now, const double* values) const {
    for (std::size_t i = 0; i < publishers_.size(); ++i) {
      const CommandTopic& topic = (*topics_)[i];
      with_type(topic.kind(), [this, &now, &topic, values, i](auto message) {
        fill(now, topic.numbers(values), message);
        publishers_[i].publish(message);
      });
    }
  }

 private:
  static constexpr std::uint32_t kQueue = 10;

  /// Calls `act` with an empty message of the kind's type.
  template <class Act>
  static void with_type(Kind kind, Act&& act) {
    switch (kind) {
      case Kind::kJoy:
        return act(sensor_msgs::Joy());
      case Kind::kWrench:
        return act(geometry_msgs::Wrench());
      case Kind::kWrenchStamped:
        return act(geometry_msgs::WrenchStamped());
      case Kind::kTwist:
        return act(geometry_msgs::Twist());
      case Kind::kTwistStamped:
        return act(geometry_msgs::TwistStamped());
      case Kind::kJointState:
        return act(sensor_msgs::JointState());
      case Kind::kArray:
        return act(std_msgs::Float64MultiArray());
      case Kind::kNumber:
        return act(std_msgs::Float64());
    }
  }

  static void fill(const ::ros::Time& now, const Numbers& from, sensor_msgs::Joy& out) {
    out.header.stamp = now;
    fill_joy(from, out);
  }
  static void fill(const ::ros::Time&, const Numbers& from, geometry_msgs::Wrench& out) {
    fill_six(from, out.force, out.torque);
  }
  static void fill(const ::ros::Time& now, const Numbers& from, geometry_msgs::WrenchStamped& out) {
    out.header.stamp = now;
    fill_six(from, out.wrench.force, out.wrench.torque);
  }
  static void fill(const ::ros::Time&, const Numbers& from, geometry_msgs::Twist& out) {
    fill_six(from, out.linear, out.angular);
  }
  static void fill(const ::ros::Time& now, const Numbers& from, geometry_msgs::TwistStamped& out) {
    out.header.stamp = now;
    fill_six(from, out.twist.linear, out.twist.angular);
  }
  static void fill(const ::ros::Time& now, const Numbers& from, sensor_msgs::JointState& out) {
    out.header.stamp = now;
    fill_joints(from, out);
  }
  static void fill(const ::ros::Time&, const Numbers& from, std_msgs::Float64MultiArray& out) {
    out.data = from[0];
  }
  static void fill(const ::ros::Time&, const Numbers& from, std_msgs::Float64& out) {
    out.data = from[0][0];
  }

  const std::vector<CommandTopic>* topics_;
  std::vector<::ros::Publisher> publishers_;
};

}  // namespace seatrial::ros
