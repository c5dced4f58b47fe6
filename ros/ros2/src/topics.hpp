// SPDX-License-Identifier: MIT
// Subscriptions of the ROS 2 nodes, also to topics whose type is not known beforehand. All are
// generic subscriptions: one instantiation of rclcpp's templates instead of one a type, which is
// most of what a node takes to compile.
#pragma once
#include <builtin_interfaces/msg/time.hpp>
#include <functional>
#include <map>
#include <memory>
#include <rclcpp/rclcpp.hpp>
#include <set>
#include <string>

namespace seatrial::ros {

using SubscriptionPtr = rclcpp::SubscriptionBase::SharedPtr;

/// A stamp [ns]. rclcpp::Time would throw on a negative one, which anybody may send.
inline std::int64_t nanoseconds(const builtin_interfaces::msg::Time& stamp) {
  return std::int64_t{1000000000} * stamp.sec + stamp.nanosec;
}

/// For streams: best effort hears reliable publishers, too.
inline rclcpp::QoS stream() { return rclcpp::SensorDataQoS().keep_last(100); }

/// Calls take(serialised message) with each.
SubscriptionPtr hear_serialized(rclcpp::Node& node, const std::string& topic,
                                const std::string& type, const rclcpp::QoS& qos,
                                std::function<void(const rclcpp::SerializedMessage&)> take);

/// Calls take(message) with each.
template <class Message, class Take>
SubscriptionPtr hear(rclcpp::Node& node, const std::string& topic, const rclcpp::QoS& qos,
                     Take take) {
  const rclcpp::Serialization<Message> serialization;
  return hear_serialized(node, topic, rosidl_generator_traits::name<Message>(), qos,
                         [take, serialization](const rclcpp::SerializedMessage& serialized) {
                           Message message;
                           serialization.deserialize_message(&serialized, &message);
                           take(message);
                         });
}

/// Subscriptions to topics of the type that their publishers have. Other subscribers do not count.
/// Where all publishers change to another type, the subscription follows.
class TypedTopics {
 public:
  /// Subscribes to a topic of a type. Throws std::runtime_error where such messages are not read.
  using Subscribe = std::function<SubscriptionPtr(const std::string&, const std::string&)>;

  TypedTopics(rclcpp::Node& node, const std::set<std::string>& topics, Subscribe subscribe);
  TypedTopics(const TypedTopics&) = delete;  // its timer holds its address
  TypedTopics& operator=(const TypedTopics&) = delete;

 private:
  struct Heard {
    std::string type;
    SubscriptionPtr subscription;
  };

  void look();
  void follow(const std::string& topic, const std::set<std::string>& types, Heard& heard);

  rclcpp::Node* node_;
  std::map<std::string, Heard> heard_;  // by topic
  Subscribe subscribe_;
  rclcpp::Clock steady_{RCL_STEADY_TIME};  // simulated time may not have begun
  rclcpp::TimerBase::SharedPtr timer_;
};

}  // namespace seatrial::ros
