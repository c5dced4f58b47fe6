// SPDX-License-Identifier: MIT
// The node's parameters: names, ranges and descriptions once, for ROS 1 and ROS 2 alike.
#pragma once
#include <cmath>
#include <sstream>
#include <stdexcept>
#include <string>
#include <type_traits>
#include <vector>

namespace seatrial::ros {

struct Settings {
  std::string model;
  std::string pose_topic;
  std::string command_topic;
  std::string odom_frame = "odom";
  std::string base_frame = "base_link";
  std::string map_frame;
  double rate = 50.0;
  bool publish_tf = true;
  bool publish_map_to_odom = false;
  bool pose_covariance = false;
  bool body_fixed_disturbance = false;
  double current_x = 0.0;
  double current_y = 0.0;
  double window = 0.5;
  double live_port = 0.0;
  std::string adapted_model;
};

/// What a parameter is; low < high: its range.
struct Parameter {
  const char* name;
  const char* description;
  double low = 0.0;
  double high = 0.0;
};

/// Calls visit(Parameter, value) for each; values are std::string, double, bool
/// or std::vector<double>.
template <class Given, class Visit>
std::enable_if_t<std::is_same_v<std::remove_const_t<Given>, Settings>> each_parameter(
    Given& s, Visit&& visit) {
  visit(Parameter{"model", "path of model.yaml, as `seatrial identify` writes it"}, s.model);
  visit(Parameter{"pose_topic",
                  "PoseStamped, PoseWithCovarianceStamped or Odometry; empty: the vehicle's"},
        s.pose_topic);
  visit(Parameter{"command_topic",
                  "Joy, Wrench, Twist (each also stamped), JointState or an array of numbers, read "
                  "as the vehicle says; empty: the vehicle's"},
        s.command_topic);
  visit(Parameter{"odom_frame", "frame that drifts and never jumps"}, s.odom_frame);
  visit(Parameter{"base_frame", "frame of the boat, at the vehicle's origin"}, s.base_frame);
  visit(Parameter{"map_frame", "frame of the poses; empty: as their messages say"}, s.map_frame);
  visit(Parameter{"rate", "of the odometry [Hz]; 0: after every command", 0.0, 200.0}, s.rate);
  visit(Parameter{"publish_tf", "odom_frame to base_frame"}, s.publish_tf);
  visit(Parameter{"publish_map_to_odom",
                  "map_frame to odom_frame; only where nobody else does, SLAM mostly does"},
        s.publish_map_to_odom);
  visit(Parameter{"pose_covariance",
                  "take the covariance of pose messages instead of the model's pose noise"},
        s.pose_covariance);
  visit(Parameter{"body_fixed_disturbance",
                  "the disturbance is body-fixed (trim), not "
                  "earth-fixed (wind, current)"},
        s.body_fixed_disturbance);
  visit(Parameter{"current_x", "known current of the water along the map's x [m/s]", -5.0, 5.0},
        s.current_x);
  visit(Parameter{"current_y", "known current of the water along the map's y [m/s]", -5.0, 5.0},
        s.current_y);
  visit(Parameter{"window", "how late or how early an input may be stamped [s]", 0.05, 5.0},
        s.window);
  visit(Parameter{"live_port",
                  "UDP port on loopback to which each pose and command is sent as a line of JSON, "
                  "for `seatrial live udp:PORT` or `seatrial predict --live --udp PORT`; 0: none",
                  0.0, 65535.0},
        s.live_port);
  visit(Parameter{"adapted_model",
                  "path to which `seatrial predict --live --adapted` writes the model of the "
                  "changed boat: the node changes to it whenever it is written; empty: never"},
        s.adapted_model);
}

/// What a parameter's value must be, in words.
template <class Value>
constexpr const char* kind_of() {
  if constexpr (std::is_same_v<Value, double>) return "a number";
  if constexpr (std::is_same_v<Value, std::vector<double>>) return "a list of numbers";
  return std::is_same_v<Value, bool> ? "true or false" : "a string";
}

/// Six digits, without zeros behind.
inline std::string plain(double value) {
  std::ostringstream text;
  text << value;
  return text.str();
}

/// Throws std::runtime_error with one line where a number is out of its range.
inline void check_range(const Parameter& p, double value) {
  if (value >= p.low && value <= p.high) return;
  throw std::runtime_error("parameter " + std::string(p.name) + " is " + plain(value) +
                           "; expected " + plain(p.low) + " to " + plain(p.high) + ": " +
                           p.description);
}

/// The same of all parameters.
template <class Given>
void check_ranges(const Given& settings) {
  struct {
    void operator()(const Parameter&, const std::string&) const {}
    void operator()(const Parameter&, bool) const {}
    void operator()(const Parameter&, const std::vector<double>&) const {}
    void operator()(const Parameter& p, double value) const { check_range(p, value); }
  } in_range;
  each_parameter(settings, in_range);
}

/// Throws std::runtime_error with one line where a value can't be used.
inline void check(const Settings& settings) {
  check_ranges(settings);
  if (settings.model.empty()) {
    throw std::runtime_error(
        "parameter model is empty; expected the path of a model.yaml (seatrial identify writes "
        "it)");
  }
  if (settings.live_port != std::floor(settings.live_port)) {
    throw std::runtime_error("parameter live_port is " + plain(settings.live_port) +
                             "; expected a whole number");
  }
}

}  // namespace seatrial::ros
