// SPDX-License-Identifier: MIT
#include "commands.hpp"

#include <geometry_msgs/msg/twist.hpp>
#include <geometry_msgs/msg/twist_stamped.hpp>
#include <geometry_msgs/msg/wrench.hpp>
#include <geometry_msgs/msg/wrench_stamped.hpp>
#include <sensor_msgs/msg/joint_state.hpp>
#include <sensor_msgs/msg/joy.hpp>
#include <std_msgs/msg/float64.hpp>
#include <std_msgs/msg/float64_multi_array.hpp>
#include <string>

namespace seatrial::ros {

namespace {

constexpr std::size_t kQueue = 10;

void fill(const rclcpp::Time& now, const Numbers& from, sensor_msgs::msg::Joy& out) {
  out.header.stamp = now;
  fill_joy(from, out);
}
void fill(const rclcpp::Time&, const Numbers& from, geometry_msgs::msg::Wrench& out) {
  fill_six(from, out.force, out.torque);
}
void fill(const rclcpp::Time& now, const Numbers& from, geometry_msgs::msg::WrenchStamped& out) {
  out.header.stamp = now;
  fill_six(from, out.wrench.force, out.wrench.torque);
}
void fill(const rclcpp::Time&, const Numbers& from, geometry_msgs::msg::Twist& out) {
  fill_six(from, out.linear, out.angular);
}
void fill(const rclcpp::Time& now, const Numbers& from, geometry_msgs::msg::TwistStamped& out) {
  out.header.stamp = now;
  fill_six(from, out.twist.linear, out.twist.angular);
}
void fill(const rclcpp::Time& now, const Numbers& from, sensor_msgs::msg::JointState& out) {
  out.header.stamp = now;
  fill_joints(from, out);
}
void fill(const rclcpp::Time&, const Numbers& from, std_msgs::msg::Float64MultiArray& out) {
  out.data = from[0];
}
void fill(const rclcpp::Time&, const Numbers& from, std_msgs::msg::Float64& out) {
  out.data = from[0][0];
}

template <class Message>
std::function<void(const rclcpp::Time&, const Numbers&)> sender(rclcpp::Node& node,
                                                                const std::string& topic) {
  const auto publisher = node.create_publisher<Message>(topic, kQueue);
  return [publisher](const rclcpp::Time& now, const Numbers& numbers) {
    Message message;
    fill(now, numbers, message);
    publisher->publish(message);
  };
}

/// Calls `act` with an empty message of the kind's type.
template <class Act>
void with_type(Kind kind, Act&& act) {
  switch (kind) {
    case Kind::kJoy:
      return act(sensor_msgs::msg::Joy());
    case Kind::kWrench:
      return act(geometry_msgs::msg::Wrench());
    case Kind::kWrenchStamped:
      return act(geometry_msgs::msg::WrenchStamped());
    case Kind::kTwist:
      return act(geometry_msgs::msg::Twist());
    case Kind::kTwistStamped:
      return act(geometry_msgs::msg::TwistStamped());
    case Kind::kJointState:
      return act(sensor_msgs::msg::JointState());
    case Kind::kArray:
      return act(std_msgs::msg::Float64MultiArray());
    case Kind::kNumber:
      return act(std_msgs::msg::Float64());
  }
}

}  // namespace

CommandPublishers::CommandPublishers(rclcpp::Node& node, const std::vector<CommandTopic>& topics) {
  for (const CommandTopic& topic : topics) {
    with_type(topic.kind(), [this, &node, &topic](auto blank) {
      outlets_.push_back({&topic, sender<decltype(blank)>(node, topic.name())});
    });
  }
}

void CommandPublishers::publish(const rclcpp::Time& now, const double* values) const {
  for (const Outlet& outlet : outlets_) outlet.send(now, outlet.topic->numbers(values));
}

}  // namespace seatrial::ros
