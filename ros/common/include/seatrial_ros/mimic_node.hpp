// SPDX-License-Identifier: MIT
// The mimic's node without ROS: its parameters, and what the shells for ROS 1 and ROS 2 do with
// commands, the carrier's odometry and time. Stamps are nanoseconds.
#pragma once
#include <memory>
#include <set>
#include <string>
#include <type_traits>
#include <utility>

#include "seatrial/simulation/mimic.hpp"
#include "seatrial_ros/diagnosis.hpp"
#include "seatrial_ros/settings.hpp"
#include "seatrial_ros/signal.hpp"

namespace seatrial::ros {

struct MimicSettings {
  std::string model;
  std::string command_topic;
  double rate = 50.0;
  bool enable_stamped_cmd_vel = false;
  double command_timeout = 0.5;
  Carrier carrier;
};

/// As of `Settings`.
template <class Given, class Visit>
std::enable_if_t<std::is_same_v<std::remove_const_t<Given>, MimicSettings>> each_parameter(
    Given& s, Visit&& visit) {
  visit(Parameter{"model", "path of model.yaml, as `seatrial identify` writes it"}, s.model);
  visit(Parameter{"command_topic", "commands to the boat; empty: the vehicle's"}, s.command_topic);
  visit(Parameter{"rate", "of cmd_vel [Hz]", 1.0, 200.0}, s.rate);
  visit(Parameter{"enable_stamped_cmd_vel", "cmd_vel is TwistStamped, not Twist"},
        s.enable_stamped_cmd_vel);
  visit(Parameter{"command_timeout",
                  "after so long without a command the virtual boat's thrust is zero, where the "
                  "vehicle states no time of its own [s]",
                  0.02, 3600.0},
        s.command_timeout);
  visit(Parameter{"speed", "the carrier's highest [m/s]", 0.001, 20.0}, s.carrier.speed);
  visit(Parameter{"yaw_rate", "its highest [rad/s]", 0.001, 50.0}, s.carrier.yaw_rate);
  visit(Parameter{"acceleration", "its highest [m/s^2]", 0.001, 100.0}, s.carrier.acceleration);
  visit(Parameter{"yaw_acceleration", "its highest [rad/s^2]", 0.001, 200.0},
        s.carrier.yaw_acceleration);
  visit(Parameter{"lag", "its delay and time constant together [s]", 0.0, 1.0}, s.carrier.lag);
  visit(Parameter{"gain", "on the carrier's error to the virtual boat's pose [1/s]", 0.0, 20.0},
        s.carrier.gain);
  visit(Parameter{"pose_timeout", "age of the carrier's pose from which it runs open-loop [s]",
                  0.01, 60.0},
        s.carrier.pose_timeout);
  visit(Parameter{"lost", "distance to the virtual boat at which it is stopped [m]", 0.01, 100.0},
        s.carrier.lost);
}

class MimicNode {
 public:
  /// Throws std::runtime_error, with one line for whoever starts it.
  explicit MimicNode(MimicSettings settings);

  const MimicSettings& settings() const { return settings_; }
  std::set<std::string> number_topics() const;

  /// As of `Node`.
  void set_type(const std::string& topic, const std::string& type) {
    command_.set_type(topic, type);
  }

  /// A command acts when it comes.
  void numbers(const NumbersMessage& in);

  /// The carrier's own pose (3) at its header's stamp; 0: none, then its arrival.
  void pose(std::int64_t stamp, std::int64_t arrival, const double* eta);

  /// What the carrier is to do from now on.
  MimicOutput tick(std::int64_t now);

  Diagnosis diagnose() const;

 private:
  std::string advice(const MimicWords& words) const;
  double seconds(std::int64_t stamp);

  MimicSettings settings_;
  std::string name_;
  Signal command_;
  std::unique_ptr<Mimic> mimic_;
  MimicOutput last_;
  std::int64_t origin_ = 0;  // [ns]
  long commands_ = 0;
  long poses_ = 0;
  long refused_ = 0;
};

}  // namespace seatrial::ros
