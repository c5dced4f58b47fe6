// SPDX-License-Identifier: MIT
#include "numbers.hpp"

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

namespace seatrial::ros {

namespace {

/// [ns]; 0: the message has no header.
template <class Message>
auto stamp_of(const Message& m, int) -> decltype(nanoseconds(m.header.stamp)) {
  return nanoseconds(m.header.stamp);
}
template <class Message>
std::int64_t stamp_of(const Message&, long) {
  return 0;
}

}  // namespace

NumberTopics::NumberTopics(rclcpp::Node& node, const std::set<std::string>& topics,
                           SetType set_type, Take take)
    : node_(&node),
      take_(std::move(take)),
      topics_(node, topics,
              [this, set_type = std::move(set_type)](const std::string& topic,
                                                     const std::string& type) {
                set_type(topic, type);
                return subscribe(topic, type);
              }) {}

template <class Message, class Read>
SubscriptionPtr NumberTopics::on(const std::string& topic, Read read) {
  return hear<Message>(*node_, topic, stream(), [this, topic, read](const Message& message) {
    take_({topic, stamp_of(message, 0), node_->now().nanoseconds(), read(message)});
  });
}

SubscriptionPtr NumberTopics::subscribe(const std::string& topic, const std::string& type) {
  using geometry_msgs::msg::Twist;
  using geometry_msgs::msg::TwistStamped;
  using geometry_msgs::msg::Wrench;
  using geometry_msgs::msg::WrenchStamped;
  using sensor_msgs::msg::JointState;
  using sensor_msgs::msg::Joy;
  using std_msgs::msg::Float32;
  using std_msgs::msg::Float32MultiArray;
  using std_msgs::msg::Float64;
  using std_msgs::msg::Float64MultiArray;
  const auto array = [](const auto& m) { return array_numbers(m); };
  const auto number = [](const auto& m) { return single_number(m); };
  switch (shape_of(type)->kind) {
    case Kind::kJoy:
      return on<Joy>(topic, [](const Joy& m) { return joy_numbers(m); });
    case Kind::kWrench:
      return on<Wrench>(topic, [](const Wrench& m) { return wrench_numbers(m); });
    case Kind::kWrenchStamped:
      return on<WrenchStamped>(topic,
                               [](const WrenchStamped& m) { return wrench_numbers(m.wrench); });
    case Kind::kTwist:
      return on<Twist>(topic, [](const Twist& m) { return twist_numbers(m); });
    case Kind::kTwistStamped:
      return on<TwistStamped>(topic, [](const TwistStamped& m) { return twist_numbers(m.twist); });
    case Kind::kJointState:
      return on<JointState>(topic, [](const JointState& m) { return joint_numbers(m); });
    case Kind::kArray:
      return type == "std_msgs/msg/Float64MultiArray" ? on<Float64MultiArray>(topic, array)
                                                      : on<Float32MultiArray>(topic, array);
    case Kind::kNumber:
      break;
  }
  return type == "std_msgs/msg/Float64" ? on<Float64>(topic, number) : on<Float32>(topic, number);
}

}  // namespace seatrial::ros
