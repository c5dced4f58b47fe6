// SPDX-License-Identifier: MIT
// Numbers of messages by the paths that a vehicle file names: axes[1], wrench.force.x.
#pragma once
#include <algorithm>
#include <stdexcept>
#include <string>
#include <vector>

#include "seatrial_ros/model_signals.hpp"

namespace seatrial::ros {

/// Messages that commands and scale signals are read from.
enum class Kind {
  kJoy,
  kWrench,
  kWrenchStamped,
  kTwist,
  kTwistStamped,
  kJointState,
  kArray,   // Float64MultiArray, Float32MultiArray
  kNumber,  // Float64, Float32
};

/// A message's numbers: the single ones, or array by array.
using Numbers = std::vector<std::vector<double>>;

/// How a kind of message is made.
struct Shape {
  Kind kind;
  std::vector<std::string> types;    // without the ROS 2 name's "/msg"
  std::vector<std::string> singles;  // paths of numbers, or
  std::vector<std::string> arrays;   // paths of arrays
};

namespace detail {

inline std::vector<std::string> vectors(const std::string& first, const std::string& second) {
  std::vector<std::string> paths;
  for (const std::string& part : {first, second}) {
    for (const char* end : {".x", ".y", ".z"}) paths.push_back(part + end);
  }
  return paths;
}

}  // namespace detail

inline const std::vector<Shape>& shapes() {
  using detail::vectors;
  static const std::vector<Shape> all = {
      {Kind::kJoy, {"sensor_msgs/Joy"}, {}, {"axes", "buttons"}},
      {Kind::kWrench, {"geometry_msgs/Wrench"}, vectors("force", "torque"), {}},
      {Kind::kWrenchStamped,
       {"geometry_msgs/WrenchStamped"},
       vectors("wrench.force", "wrench.torque"),
       {}},
      {Kind::kTwist, {"geometry_msgs/Twist"}, vectors("linear", "angular"), {}},
      {Kind::kTwistStamped,
       {"geometry_msgs/TwistStamped"},
       vectors("twist.linear", "twist.angular"),
       {}},
      {Kind::kJointState, {"sensor_msgs/JointState"}, {}, {"position", "velocity", "effort"}},
      {Kind::kArray, {"std_msgs/Float64MultiArray", "std_msgs/Float32MultiArray"}, {}, {"data"}},
      {Kind::kNumber, {"std_msgs/Float64", "std_msgs/Float32"}, {"data"}, {}},
  };
  return all;
}

/// The shape of a type as either ROS names it; null: none that is read.
inline const Shape* shape_of(std::string type) {
  const std::size_t infix = type.find("/msg/");
  if (infix != std::string::npos) type.erase(infix, 4);
  for (const Shape& shape : shapes()) {
    if (std::find(shape.types.begin(), shape.types.end(), type) != shape.types.end()) {
      return &shape;
    }
  }
  return nullptr;
}

/// Where a channel's number stands in a message's numbers.
struct Place {
  std::size_t group = 0;
  std::size_t index = 0;
};

/// Throws std::runtime_error where such messages have no such field; it names the type as `type`.
inline Place place_in(const Shape& shape, const Channel& channel, const std::string& type = "") {
  const auto find = [&channel](const std::vector<std::string>& paths) {
    return std::find(paths.begin(), paths.end(), channel.field) - paths.begin();
  };
  Place place;
  if (channel.index < 0) {
    place.index = static_cast<std::size_t>(find(shape.singles));
    if (place.index < shape.singles.size()) return place;
  } else {
    place.group = static_cast<std::size_t>(find(shape.arrays));
    place.index = static_cast<std::size_t>(channel.index);
    if (place.group < shape.arrays.size()) return place;
  }
  std::vector<std::string> paths = shape.singles;
  for (const std::string& array : shape.arrays) paths.push_back(array + "[i]");
  const std::string asked =
      channel.field + (channel.index < 0 ? "" : "[" + std::to_string(channel.index) + "]");
  throw std::runtime_error(channel.topic + " (" + (type.empty() ? shape.types.front() : type) +
                           ") has no field '" + asked + "' for " + channel.name + "; expected " +
                           joined(paths));
}

}  // namespace seatrial::ros
