// SPDX-License-Identifier: MIT
// Subscriptions of the ROS 2 nodes, also to topics whose type is not known beforehand.
#pragma once
#include <builtin_interfaces/msg/time.hpp>
#include <chrono>
#include <functional>
#include <iterator>
#include <map>
#include <memory>
#include <rclcpp/rclcpp.hpp>
#include <set>
#include <stdexcept>
#include <string>
#include <vector>

namespace seatrial::ros {

using SubscriptionPtr = rclcpp::SubscriptionBase::SharedPtr;

/// A stamp [ns]. rclcpp::Time would throw on a negative one, which anybody may send.
inline std::int64_t nanoseconds(const builtin_interfaces::msg::Time& stamp) {
  return std::int64_t{1000000000} * stamp.sec + stamp.nanosec;
}

/// For streams: best effort hears reliable publishers, too.
inline rclcpp::QoS stream() { return rclcpp::SensorDataQoS().keep_last(100); }

/// Calls take(message) with each.
template <class Message, class Take>
SubscriptionPtr hear(rclcpp::Node& node, const std::string& topic, const rclcpp::QoS& qos,
                     Take take) {
  return node.create_subscription<Message>(
      topic, qos, [take](const std::shared_ptr<const Message> message) { take(*message); });
}

/// Subscriptions to topics whose type is known once they have a publisher.
class AwaitedTopics {
 public:
  /// Subscribes to a topic of a type. Throws std::runtime_error where such messages are not read.
  using Subscribe = std::function<SubscriptionPtr(const std::string&, const std::string&)>;

  AwaitedTopics(rclcpp::Node& node, std::set<std::string> topics, Subscribe subscribe)
      : node_(&node),
        awaited_(std::move(topics)),
        subscribe_(std::move(subscribe)),
        timer_(node.create_wall_timer(std::chrono::milliseconds(500), [this] { look(); })) {
    look();
  }
  AwaitedTopics(const AwaitedTopics&) = delete;  // its timer holds its address
  AwaitedTopics& operator=(const AwaitedTopics&) = delete;

 private:
  using Types = std::map<std::string, std::vector<std::string>>;

  void look() {
    if (awaited_.empty()) return;
    const Types known = node_->get_topic_names_and_types();
    for (auto topic = awaited_.begin(); topic != awaited_.end();) {
      topic = subscribed(*topic, known) ? awaited_.erase(topic) : std::next(topic);
    }
  }

  bool subscribed(const std::string& topic, const Types& known) {
    const auto found = known.find(node_->get_node_topics_interface()->resolve_topic_name(topic));
    if (found == known.end() || found->second.empty()) return false;
    try {
      subscriptions_.push_back(subscribe_(topic, found->second.front()));
      return true;
    } catch (const std::runtime_error& error) {
      RCLCPP_ERROR_THROTTLE(node_->get_logger(), steady_, 10000, "%s", error.what());
      return false;
    }
  }

  rclcpp::Node* node_;
  std::set<std::string> awaited_;
  Subscribe subscribe_;
  std::vector<SubscriptionPtr> subscriptions_;
  rclcpp::Clock steady_{RCL_STEADY_TIME};  // simulated time may not have begun
  rclcpp::TimerBase::SharedPtr timer_;
};

}  // namespace seatrial::ros
