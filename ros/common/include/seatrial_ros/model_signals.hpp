// SPDX-License-Identifier: MIT
// How a vehicle's signals are read from messages: which field of which topic, and what makes it
// forward-left-up SI.
#pragma once
#include <cmath>
#include <optional>

#include "seatrial/model/frames.hpp"
#include "seatrial_ros/model_value.hpp"

namespace seatrial::ros {

/// A number out of each message of a topic: value = gain * raw + offset, forward-left-up, SI.
struct Channel {
  std::string name;   // of the input or scale
  std::string topic;  // empty: the file names none
  std::string field;  // a path through the message, for instance wrench.force.x; empty: none named
  int index = -1;     // into the array that `field` names; -1: `field` is the number
  double gain = 1.0;
  double offset = 0.0;
  double turn = 1.0;  // -1: positive in the file's axes is negative in forward-left-up

  double off = std::nan("");  // raw value that means no command; NaN: none does

  double value(double raw) const { return raw == off ? 0.0 : gain * raw + offset; }
};

enum class Clock { kHeader, kBag };  // stamps of the messages, or of their arrival

/// Where the pose comes from. What x, y and psi make of the numbers is the pose of a point at
/// `lever`, forward-left-up.
struct PoseSource {
  std::string topic;   // empty: the file names none
  std::string parent;  // frames of a tf, or of messages from several; empty: any
  std::string child;
  Clock clock = Clock::kHeader;
  Channel x;  // without a field: of the usual position in the message
  Channel y;
  Channel psi;                   // of an angle in the message (its own field, or Pose2D's theta)
  Channel heading;               // of a heading [rad] that is made of a quaternion
  double lever[2] = {0.0, 0.0};  // [m] the measured point from the boat's origin: forward, left
  double position_delay = 0.0;   // [s] by which the position is older than its stamp
  double heading_delay = 0.0;    // [s] by which the heading is
};

/// Where the commands come from; scales have their clock.
struct CommandSource {
  std::string topic;  // that of channels which name none; empty: the file names none
  Clock clock = Clock::kHeader;
};

namespace detail {

inline const Words kLengthUnits = {"m", "cm", "mm"};
inline const Words kAngleUnits = {"rad", "deg"};
inline const Words kUnits = {"m", "cm", "mm", "rad", "deg", "-"};

/// SI units in one of these.
inline double to_si(const std::string& unit) {
  if (unit == "cm") return 1e-2;
  if (unit == "mm") return 1e-3;
  return unit == "deg" ? kPi / 180.0 : 1.0;
}

inline std::string text_or(const Value& mapping, const std::string& key, const std::string& other) {
  const auto found = mapping.find(key);
  return found ? found->text() : other;
}

inline Clock read_clock(const Value& source) {
  const auto given = source.find("clock");
  return given && given->choice({"header", "bag"}) == 1 ? Clock::kBag : Clock::kHeader;
}

/// The same path, whether the index stands in it or beside it.
inline void split_index(Channel& c) {
  const std::size_t open = c.field.rfind('[');
  if (c.index >= 0 || c.field.empty() || c.field.back() != ']' || open == std::string::npos) {
    return;
  }
  const std::string digits = c.field.substr(open + 1, c.field.size() - open - 2);
  const bool whole = !digits.empty() && digits.size() < 7 &&
                     std::all_of(digits.begin(), digits.end(),
                                 [](unsigned char d) { return d >= '0' && d <= '9'; });
  if (!whole) return;
  c.index = std::stoi(digits);
  c.field.resize(open);
}

/// A column of the vehicle file, value = sign (raw - offset) / scale in its unit; absent: as it is.
/// turn: -1 where it changes sign to forward-left-up. raw_is_si: the number is SI already, the unit
/// is of the offset only.
inline Channel read_channel(const std::optional<Value>& given, const std::string& name,
                            const std::string& topic, const Words& units, double turn,
                            bool raw_is_si = false) {
  Channel c;
  c.name = name;
  c.topic = topic;
  c.gain = turn;
  c.turn = turn;
  if (!given) return c;
  if (given->is_word()) {
    c.field = given->text();
    split_index(c);
    return c;
  }
  given->only({"column", "field", "index", "topic", "file", "stamp", "unit", "sign", "scale",
               "offset", "off", "nanoseconds", "quaternion"});
  c.field = text_or(*given, "field", "");
  c.topic = text_or(*given, "topic", topic);
  if (const auto index = given->find("index")) {
    const double at = index->not_negative();
    if (at != std::floor(at) || at > 1e6) index->refuse("expected a whole number from 0 on");
    c.index = static_cast<int>(at);
  }
  split_index(c);
  double unit = 1.0;
  if (const auto own = given->find("unit")) {
    unit = to_si(units[static_cast<std::size_t>(own->choice(units))]);
  }
  double sign = 1.0;
  if (const auto own = given->find("sign")) {
    sign = own->number();
    if (std::abs(sign) != 1.0) own->refuse("expected 1 or -1");
  }
  const auto scale = given->find("scale");
  const auto offset = given->find("offset");
  const double per_unit = turn * sign / (scale ? scale->positive() : 1.0);
  const double shift = offset ? offset->number() : 0.0;
  if (const auto own = given->find("off")) c.off = own->number();
  c.gain = raw_is_si ? per_unit : per_unit * unit;
  c.offset = 0.0 - per_unit * unit * shift;
  return c;
}

/// A delay [s]; none where it is absent or was left to the estimator.
inline std::optional<double> read_delay(const Value& pose, const std::string& key) {
  const auto given = pose.find(key);
  if (!given || (given->is_word() && given->text() == "estimate")) return std::nullopt;
  const double delay = given->number();
  if (!(std::abs(delay) <= 1.0)) given->refuse("expected a delay from -1 s to 1 s");
  return delay;
}

/// As in Python's `Vehicle.delays`.
inline void read_delays(const Value& pose, PoseSource& source) {
  const auto position = read_delay(pose, "delay");
  const auto heading = read_delay(pose, "heading_delay");
  const bool open = pose.find("delay").has_value() && !position;
  source.position_delay = position.value_or(open ? heading.value_or(0.0) : 0.0);
  source.heading_delay = heading.value_or(source.position_delay);
}

}  // namespace detail

/// `vehicle.pose`. Throws std::runtime_error.
inline PoseSource read_pose_source(const Value& pose, bool from_right_down) {
  using detail::read_channel;
  pose.only({"stamp", "x", "y", "psi", "file", "valid", "topic", "parent", "child", "clock",
             "lever", "delay", "heading_delay", "latitude", "longitude", "origin", "yaw_rate"});
  if (const auto latitude = pose.find("latitude")) {
    latitude->refuse("expected x and y in metres: name the topic of a pose in the vehicle file");
  }
  PoseSource source;
  source.topic = detail::text_or(pose, "topic", "");
  source.parent = detail::text_or(pose, "parent", "");
  source.child = detail::text_or(pose, "child", "");
  source.clock = detail::read_clock(pose);
  const double turn = from_right_down ? -1.0 : 1.0;
  const auto psi = pose.find("psi");
  source.x = read_channel(pose.find("x"), "x", source.topic, detail::kLengthUnits, 1.0);
  source.y = read_channel(pose.find("y"), "y", source.topic, detail::kLengthUnits, turn);
  source.psi = read_channel(psi, "psi", source.topic, detail::kAngleUnits, turn);
  source.heading = read_channel(psi, "psi", source.topic, detail::kAngleUnits, turn, true);
  if (const auto lever = pose.find("lever")) {
    const std::vector<Value> ends = lever->items();
    if (ends.size() != 2) lever->refuse("expected two numbers: forward, second axis [m]");
    source.lever[0] = ends[0].number();
    source.lever[1] = turn * ends[1].number();
  }
  detail::read_delays(pose, source);
  return source;
}

}  // namespace seatrial::ros
