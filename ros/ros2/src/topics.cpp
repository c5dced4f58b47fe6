// SPDX-License-Identifier: MIT
#include "topics.hpp"

#include <chrono>
#include <stdexcept>
#include <utility>

namespace seatrial::ros {

SubscriptionPtr hear_serialized(rclcpp::Node& node, const std::string& topic,
                                const std::string& type, const rclcpp::QoS& qos,
                                std::function<void(const rclcpp::SerializedMessage&)> take) {
  const std::function<void(std::shared_ptr<rclcpp::SerializedMessage>)> call =
      [take = std::move(take)](const std::shared_ptr<rclcpp::SerializedMessage>& message) {
        take(*message);
      };
  return node.create_generic_subscription(topic, type, qos, call);
}

TypedTopics::TypedTopics(rclcpp::Node& node, const std::set<std::string>& topics,
                         Subscribe subscribe)
    : node_(&node),
      subscribe_(std::move(subscribe)),
      timer_(node.create_wall_timer(std::chrono::milliseconds(500), [this] { look(); })) {
  for (const std::string& topic : topics) heard_[topic];
  look();
}

void TypedTopics::look() {
  for (auto& [topic, heard] : heard_) {
    std::set<std::string> types;
    for (const auto& publisher : node_->get_publishers_info_by_topic(topic)) {
      types.insert(publisher.topic_type());
    }
    // no publisher yet, or none any more; or all as before
    if (types.empty() || types.count(heard.type) != 0) continue;
    follow(topic, types, heard);
  }
}

void TypedTopics::follow(const std::string& topic, const std::set<std::string>& types,
                         Heard& heard) {
  std::string wrong;
  for (const std::string& type : types) {
    try {
      heard.subscription = subscribe_(topic, type);
      heard.type = type;
      RCLCPP_INFO(node_->get_logger(), "%s is %s%s", topic.c_str(), type.c_str(),
                  types.size() > 1 ? "; publishers of other types are not heard" : "");
      return;
    } catch (const std::runtime_error& error) {
      wrong = error.what();
    }
  }
  RCLCPP_ERROR_THROTTLE(node_->get_logger(), steady_, 10000, "%s", wrong.c_str());
}

}  // namespace seatrial::ros
