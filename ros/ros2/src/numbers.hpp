// SPDX-License-Identifier: MIT
// Commands and scale signals out of ROS 2 messages of any type.
#pragma once
#include <functional>
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
#include <utility>

#include "seatrial_ros/signal.hpp"
#include "topics.hpp"

namespace seatrial::ros {

/// Subscriptions to all topics that a node wants numbers from (number_topics, set_type).
template <class Node>
class NumberTopics {
 public:
  using Take = std::function<void(const NumbersMessage&)>;

  NumberTopics(rclcpp::Node& shell, Node& node, Take take)
      : shell_(&shell),
        node_(&node),
        take_(std::move(take)),
        topics_(shell, node.number_topics(),
                [this](const std::string& topic, const std::string& type) {
                  node_->set_type(topic, type);
                  return subscribe(topic, type);
                }) {}

 private:
  SubscriptionPtr subscribe(const std::string& topic, const std::string& type) {
    switch (shape_of(type)->kind) {
      case Kind::kJoy:
        return on<sensor_msgs::msg::Joy>(topic, [](const auto& m) { return joy_numbers(m); });
      case Kind::kWrench:
        return on<geometry_msgs::msg::Wrench>(topic,
                                              [](const auto& m) { return wrench_numbers(m); });
      case Kind::kWrenchStamped:
        return on<geometry_msgs::msg::WrenchStamped>(
            topic, [](const auto& m) { return wrench_numbers(m.wrench); });
      case Kind::kTwist:
        return on<geometry_msgs::msg::Twist>(topic, [](const auto& m) { return twist_numbers(m); });
      case Kind::kTwistStamped:
        return on<geometry_msgs::msg::TwistStamped>(
            topic, [](const auto& m) { return twist_numbers(m.twist); });
      case Kind::kJointState:
        return on<sensor_msgs::msg::JointState>(topic,
                                                [](const auto& m) { return joint_numbers(m); });
      case Kind::kArray: {
        const auto read = [](const auto& m) { return array_numbers(m); };
        return type == "std_msgs/msg/Float64MultiArray"
                   ? on<std_msgs::msg::Float64MultiArray>(topic, read)
                   : on<std_msgs::msg::Float32MultiArray>(topic, read);
      }
      case Kind::kNumber:
        break;
    }
    const auto read = [](const auto& m) { return single_number(m); };
    return type == "std_msgs/msg/Float64" ? on<std_msgs::msg::Float64>(topic, read)
                                          : on<std_msgs::msg::Float32>(topic, read);
  }

  template <class Message, class Read>
  SubscriptionPtr on(const std::string& topic, Read read) {
    return hear<Message>(*shell_, topic, stream(), [this, topic, read](const Message& message) {
      take_({topic, stamp_of(message, 0), shell_->now().nanoseconds(), read(message)});
    });
  }

  /// [ns]; 0: the message has no header.
  template <class Message>
  static auto stamp_of(const Message& m, int) -> decltype(nanoseconds(m.header.stamp)) {
    return nanoseconds(m.header.stamp);
  }
  template <class Message>
  static std::int64_t stamp_of(const Message&, long) {
    return 0;
  }

  rclcpp::Node* shell_;
  Node* node_;
  Take take_;
  AwaitedTopics topics_;
};

}  // namespace seatrial::ros
