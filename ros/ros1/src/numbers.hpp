// SPDX-License-Identifier: MIT
// What the ROS 1 nodes have in common: parameters, stamps, and commands out of messages of any
// type.
#pragma once
#include <geometry_msgs/TwistStamped.h>
#include <geometry_msgs/WrenchStamped.h>
#include <ros/ros.h>
#include <sensor_msgs/JointState.h>
#include <sensor_msgs/Joy.h>
#include <std_msgs/Float32.h>
#include <std_msgs/Float32MultiArray.h>
#include <std_msgs/Float64.h>
#include <std_msgs/Float64MultiArray.h>
#include <topic_tools/shape_shifter.h>

#include <functional>
#include <map>

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

inline void fill(const std::string& type, const ShapeShifter& any, NumbersMessage& in) {
  const auto stamped = [&in](const auto& m) { in.stamp = nanoseconds(m.header.stamp); };
  switch (shape_of(type)->kind) {
    case Kind::kJoy: {
      const auto m = any.instantiate<sensor_msgs::Joy>();
      stamped(*m);
      in.numbers = joy_numbers(*m);
      break;
    }
    case Kind::kWrench:
      in.numbers = wrench_numbers(*any.instantiate<geometry_msgs::Wrench>());
      break;
    case Kind::kWrenchStamped: {
      const auto m = any.instantiate<geometry_msgs::WrenchStamped>();
      stamped(*m);
      in.numbers = wrench_numbers(m->wrench);
      break;
    }
    case Kind::kTwist:
      in.numbers = twist_numbers(*any.instantiate<geometry_msgs::Twist>());
      break;
    case Kind::kTwistStamped: {
      const auto m = any.instantiate<geometry_msgs::TwistStamped>();
      stamped(*m);
      in.numbers = twist_numbers(m->twist);
      break;
    }
    case Kind::kJointState: {
      const auto m = any.instantiate<sensor_msgs::JointState>();
      stamped(*m);
      in.numbers = joint_numbers(*m);
      break;
    }
    case Kind::kArray:
      in.numbers = type == "std_msgs/Float64MultiArray"
                       ? array_numbers(*any.instantiate<std_msgs::Float64MultiArray>())
                       : array_numbers(*any.instantiate<std_msgs::Float32MultiArray>());
      break;
    case Kind::kNumber:
      in.numbers = type == "std_msgs/Float64"
                       ? single_number(*any.instantiate<std_msgs::Float64>())
                       : single_number(*any.instantiate<std_msgs::Float32>());
      break;
  }
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
    fill(type, any, in);
    take_(in);
  }

  Node* node_;
  Take take_;
  std::map<std::string, std::string> types_;
  std::vector<::ros::Subscriber> subscribers_;  // last, so gone first
};

}  // namespace seatrial::ros
