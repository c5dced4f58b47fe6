// SPDX-License-Identifier: MIT
// Commands as messages of ROS 1, of whatever type the vehicle says.
#pragma once
#include <ros/ros.h>

#include <vector>

#include "message_types.hpp"
#include "seatrial_ros/command_writer.hpp"

namespace seatrial::ros {

/// Publishers of all topics of a vehicle's commands.
class CommandPublishers {
 public:
  CommandPublishers(::ros::NodeHandle& handle, const std::vector<CommandTopic>& topics)
      : topics_(&topics) {
    for (const CommandTopic& topic : topics) {
      with_message<Messages>(topic.kind(), false, [this, &handle, &topic](auto message) {
        publishers_.push_back(handle.advertise<decltype(message)>(topic.name(), kQueue));
      });
    }
  }

  void publish(const ::ros::Time& now, const double* values) const {
    for (std::size_t i = 0; i < publishers_.size(); ++i) {
      const CommandTopic& topic = (*topics_)[i];
      with_message<Messages>(topic.kind(), false, [this, &now, &topic, values, i](auto message) {
        with_header(message, [&now](auto& header) { header.stamp = now; });
        put_numbers(topic.numbers(values), message);
        publishers_[i].publish(message);
      });
    }
  }

 private:
  static constexpr std::uint32_t kQueue = 10;

  const std::vector<CommandTopic>* topics_;
  std::vector<::ros::Publisher> publishers_;
};

}  // namespace seatrial::ros
