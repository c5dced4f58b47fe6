// SPDX-License-Identifier: MIT
#include "numbers.hpp"

#include <utility>

#include "message_types.hpp"

namespace seatrial::ros {

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

SubscriptionPtr NumberTopics::subscribe(const std::string& topic, const std::string& type) {
  return with_message<Messages>(type, [this, &topic](auto blank) {
    using Message = decltype(blank);
    return hear<Message>(*node_, topic, stream(), [this, topic](const Message& message) {
      NumbersMessage in;
      in.topic = topic;
      in.arrival = node_->now().nanoseconds();
      with_header(message, [&in](const auto& header) { in.stamp = nanoseconds(header.stamp); });
      in.numbers = numbers_in(message);
      take_(in);
    });
  });
}

}  // namespace seatrial::ros
