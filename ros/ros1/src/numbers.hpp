// SPDX-License-Identifier: MIT
// What the ROS 1 nodes have in common: parameters, stamps, and commands out of messages of any
// type.
#pragma once
#include <ros/ros.h>
#include <topic_tools/shape_shifter.h>

#include <functional>
#include <map>

#include "message_types.hpp"
#include "seatrial_ros/settings.hpp"
#include "seatrial_ros/signal.hpp"

namespace seatrial::ros {

using topic_tools::ShapeShifter;

inline std::int64_t nanoseconds(const ::ros::Time& t) {
  return static_cast<std::int64_t>(t.toNSec());
}

/// The parameters of the private namespace.
template <class Given>
Given read_settings(const ::ros::NodeHandle& own) {
  Given settings;
  each_parameter(settings, [&own](const Parameter& p, auto& value) {
    using Value = std::decay_t<decltype(value)>;
    if (own.hasParam(p.name) && !own.getParam(p.name, value)) {
      throw std::runtime_error("parameter " + std::string(p.name) +
                               " is of another type; expected " + kind_of<Value>() + ": " +
                               p.description);
    }
  });
  return settings;
}

/// Subscriptions to all topics that a node wants numbers from (number_topics, set_type).
template <class Node>
class NumberTopics {
 public:
  using Take = std::function<void(const NumbersMessage&)>;

  NumberTopics(::ros::NodeHandle& handle, Node& node, Take take)
      : node_(&node), take_(std::move(take)) {
    const auto hints = ::ros::TransportHints().tcpNoDelay();
    for (const std::string& topic : node.number_topics()) {
      const boost::function<void(const ::ros::MessageEvent<ShapeShifter const>&)> hear =
          [this, topic](const ::ros::MessageEvent<ShapeShifter const>& event) {
            on_message(topic, *event.getConstMessage());
          };
      subscribers_.push_back(
          handle.subscribe<ShapeShifter>(topic, kQueue, hear, ::ros::VoidConstPtr(), hints));
    }
  }

 private:
  static constexpr std::uint32_t kQueue = 100;

  void on_message(const std::string& topic, const ShapeShifter& any) {
    const std::string& type = any.getDataType();
    if (types_[topic] != type) {
      types_[topic].clear();
      try {
        node_->set_type(topic, type);
      } catch (const std::runtime_error& error) {  // until a model is reloaded that reads them
        ROS_ERROR_THROTTLE(10.0, "%s", error.what());
        return;
      }
      types_[topic] = type;
    }
    NumbersMessage in;
    in.topic = topic;
    in.arrival = nanoseconds(::ros::Time::now());
    with_message<Messages>(type, [&any, &in](auto blank) {
      const auto message = any.instantiate<decltype(blank)>();
      with_header(*message, [&in](const auto& header) { in.stamp = nanoseconds(header.stamp); });
      in.numbers = numbers_in(*message);
    });
    take_(in);
  }

  Node* node_;
  Take take_;
  std::map<std::string, std::string> types_;
  std::vector<::ros::Subscriber> subscribers_;  // last, so gone first
};

}  // namespace seatrial::ros
