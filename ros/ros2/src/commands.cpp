// SPDX-License-Identifier: MIT
#include "commands.hpp"

#include <string>

#include "message_types.hpp"

namespace seatrial::ros {

namespace {

constexpr std::size_t kQueue = 10;

template <class Message>
std::function<void(const rclcpp::Time&, const Numbers&)> sender(rclcpp::Node& node,
                                                                const std::string& topic) {
  const auto publisher = node.create_publisher<Message>(topic, kQueue);
  return [publisher](const rclcpp::Time& now, const Numbers& numbers) {
    Message message;
    with_header(message, [&now](auto& header) { header.stamp = now; });
    put_numbers(numbers, message);
    publisher->publish(message);
  };
}

}  // namespace

CommandPublishers::CommandPublishers(rclcpp::Node& node, const std::vector<CommandTopic>& topics) {
  for (const CommandTopic& topic : topics) {
    with_message<Messages>(topic.kind(), false, [this, &node, &topic](auto blank) {
      outlets_.push_back({&topic, sender<decltype(blank)>(node, topic.name())});
    });
  }
}

void CommandPublishers::publish(const rclcpp::Time& now, const double* values) const {
  for (const Outlet& outlet : outlets_) outlet.send(now, outlet.topic->numbers(values));
}

}  // namespace seatrial::ros
