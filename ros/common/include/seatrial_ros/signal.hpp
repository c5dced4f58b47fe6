// SPDX-License-Identifier: MIT
// Commands and scale signals out of messages of any type, as the vehicle file says.
#pragma once
#include <cstdint>
#include <limits>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "seatrial_ros/fields.hpp"
#include "seatrial_ros/model_file.hpp"

namespace seatrial::ros {

/// A message of commands or scale signals.
struct NumbersMessage {
  std::string topic;
  std::int64_t stamp = 0;    // [ns] of its header; 0: none
  std::int64_t arrival = 0;  // [ns]
  Numbers numbers;
};

/// The shape of a topic's type. Throws std::runtime_error where such messages are not read.
inline const Shape& known_shape(const std::string& topic, const std::string& type) {
  const Shape* shape = shape_of(type);
  if (shape != nullptr) return *shape;
  const bool ros2 = type.find("/msg/") != std::string::npos;
  Words known;
  for (const Shape& s : shapes()) {
    for (std::string name : s.types) {
      if (ros2) name.insert(name.find('/'), "/msg");
      known.push_back(name);
    }
  }
  throw std::runtime_error(topic + " is " + type + "; expected one of " + joined(known));
}

/// Throws std::runtime_error where the vehicle does not say where its commands are read from.
inline void expect_named(const BoardModel& board, const std::string& path) {
  for (const auto* channels : {&board.inputs, &board.scales}) {
    for (const Channel& c : *channels) {
      if (!c.topic.empty() && !c.field.empty()) continue;
      throw std::runtime_error("the vehicle of " + path + " names no " +
                               (c.topic.empty() ? "topic" : "field") + " for " + c.name +
                               "; write it into the vehicle file (commands: {topic: /joy, "
                               "inputs: {F_u: 'axes[1]', ...}}) and identify again");
    }
  }
}

/// Numbers that come together as one row, from one or several topics.
class Signal {
 public:
  Signal() = default;
  /// timeout [s]: a topic that is silent for longer has no value; infinite: its last one holds.
  explicit Signal(std::vector<Channel> channels,
                  double timeout = std::numeric_limits<double>::infinity())
      : channels_(std::move(channels)),
        timeout_(timeout),
        places_(channels_.size()),
        came_(channels_.size()),
        values_(channels_.size(), 0.0) {}

  /// What a topic's messages are, named as either ROS names types. Throws std::runtime_error where
  /// such messages are not read, or lack one of its fields.
  void set_type(const std::string& topic, const std::string& type) {
    const Shape& shape = known_shape(topic, type);
    for (std::size_t i = 0; i < channels_.size(); ++i) {
      if (channels_[i].topic == topic) places_[i] = place_in(shape, channels_[i], type);
    }
  }

  /// True where the message has some of its numbers, and all others have come, none of them longer
  /// ago than the timeout.
  bool update(const NumbersMessage& in) {
    bool own = false;
    for (std::size_t i = 0; i < channels_.size(); ++i) {
      if (channels_[i].topic != in.topic) continue;
      own = true;
      const Place& at = places_[i];
      const bool there = at.group < in.numbers.size() && at.index < in.numbers[at.group].size();
      const double raw = there ? in.numbers[at.group][at.index]
                               : std::numeric_limits<double>::quiet_NaN();  // refused, and counted
      values_[i] = channels_[i].value(raw);
      came_[i] = in.arrival;
    }
    return own && std::all_of(came_.begin(), came_.end(), [this, &in](const auto& at) {
             return at && 1e-9 * static_cast<double>(in.arrival - *at) <= timeout_;
           });
  }

  const double* values() const { return values_.data(); }
  std::size_t size() const { return values_.size(); }
  const std::vector<Channel>& channels() const { return channels_; }

 private:
  std::vector<Channel> channels_;
  double timeout_ = std::numeric_limits<double>::infinity();  // [s]
  std::vector<Place> places_;
  std::vector<std::optional<std::int64_t>> came_;  // [ns] arrival of the message it is of
  std::vector<double> values_;
};

}  // namespace seatrial::ros
