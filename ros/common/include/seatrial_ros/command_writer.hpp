// SPDX-License-Identifier: MIT
// Commands into messages, as the vehicle file says: what `Signal` reads, the other way round.
#pragma once
#include <algorithm>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "seatrial_ros/fields.hpp"

namespace seatrial::ros {

/// One topic of a vehicle's commands. Its messages are of the first type that has its fields.
class CommandTopic {
 public:
  /// Throws std::runtime_error where no message can carry these commands.
  CommandTopic(std::string name, const std::vector<Channel>& channels) : name_(std::move(name)) {
    const Channel* first = nullptr;
    for (const Channel& c : channels) {
      if (c.topic == name_ && first == nullptr) first = &c;
    }
    shape_ = shape_with(*first);
    blank_.resize(std::max<std::size_t>(shape_->arrays.size(), 1));
    if (shape_->arrays.empty()) blank_[0].resize(shape_->singles.size());
    for (std::size_t i = 0; i < channels.size(); ++i) {
      if (channels[i].topic == name_) add(channels[i], i);
    }
  }

  const std::string& name() const { return name_; }
  Kind kind() const { return shape_->kind; }

  /// A message's numbers by the commands to all inputs; others are zero.
  Numbers numbers(const double* values) const {
    Numbers out = blank_;
    for (const Part& p : parts_) {
      out[p.place.group][p.place.index] = (values[p.input] - p.offset) / p.gain;
    }
    return out;
  }

 private:
  struct Part {
    Place place;
    std::size_t input;
    double gain;
    double offset;
  };

  static const Shape* shape_with(const Channel& c) {
    for (const Shape& shape : shapes()) {
      const auto& paths = c.index < 0 ? shape.singles : shape.arrays;
      if (std::find(paths.begin(), paths.end(), c.field) != paths.end()) return &shape;
    }
    throw std::runtime_error(c.topic + ": no message that is known has a field '" + c.field +
                             "' for " + c.name + "; commands go out as Joy, Wrench, Twist, " +
                             "JointState, Float64MultiArray or Float64");
  }

  void add(const Channel& c, std::size_t input) {
    const Place place = place_in(*shape_, c);
    if (c.field == "buttons") {
      throw std::runtime_error(c.topic + ": " + c.name +
                               " is a button, which is on or off; commands need an axis");
    }
    std::vector<double>& group = blank_[place.group];
    if (place.index >= group.size()) group.resize(place.index + 1);
    parts_.push_back({place, input, c.gain, c.offset});
  }

  std::string name_;
  const Shape* shape_ = nullptr;
  Numbers blank_;
  std::vector<Part> parts_;
};

/// All topics of a vehicle's commands. Throws std::runtime_error.
inline std::vector<CommandTopic> command_topics(const std::vector<Channel>& channels) {
  std::set<std::string> names;
  for (const Channel& c : channels) names.insert(c.topic);
  std::vector<CommandTopic> topics;
  topics.reserve(names.size());
  for (const std::string& name : names) topics.emplace_back(name, channels);
  return topics;
}

}  // namespace seatrial::ros
