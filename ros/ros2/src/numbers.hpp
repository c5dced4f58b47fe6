// SPDX-License-Identifier: MIT
// Commands and scale signals out of ROS 2 messages of any type.
#pragma once
#include <functional>
#include <set>
#include <string>
#include <utility>

#include "seatrial_ros/signal.hpp"
#include "topics.hpp"

namespace seatrial::ros {

/// Subscriptions to all topics that a node wants numbers from.
class NumberTopics {
 public:
  using SetType = std::function<void(const std::string& topic, const std::string& type)>;
  using Take = std::function<void(const NumbersMessage&)>;

  /// set_type: before the first message of a type; throws where such messages are not read.
  NumberTopics(rclcpp::Node& node, const std::set<std::string>& topics, SetType set_type,
               Take take);

  /// Of a node with number_topics() and set_type().
  template <class Node>
  NumberTopics(rclcpp::Node& shell, Node& node, Take take)
      : NumberTopics(
            shell, node.number_topics(),
            [&node](const std::string& topic, const std::string& type) {
              node.set_type(topic, type);
            },
            std::move(take)) {}

 private:
  SubscriptionPtr subscribe(const std::string& topic, const std::string& type);

  rclcpp::Node* node_;
  Take take_;
  TypedTopics topics_;
};

}  // namespace seatrial::ros
