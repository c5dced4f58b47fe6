// SPDX-License-Identifier: MIT
// The tracking node's parameters, for ROS 1 and ROS 2 alike.
#pragma once
#include <vector>

#include "seatrial_ros/settings.hpp"

namespace seatrial::ros {

struct TrackingSettings {
  std::string model;
  std::string gains;
  std::string command_topic;
  bool control_in_map = true;
  bool feed_forward = true;
  double rate = 0.0;
  double timeout = 0.5;
  double reference_timeout = 0.5;
  double position_uncertainty = 0.3;
  double heading_uncertainty = 0.3;
  // instead of the file `gains`, as `seatrial tune --ros` writes them
  std::vector<double> proportional;
  std::vector<double> integral;
  std::vector<double> derivative;
  std::vector<double> authority;
  std::vector<double> mix;
  std::vector<double> guidance;
  double lead = 0.0;
  double limit = 1.0;
  std::string allocation;
  std::vector<double> allocation_rank;
  double allocation_hysteresis = 0.0;
  std::vector<double> allocation_thrusters;
};

/// As of `Settings`.
template <class Given, class Visit>
std::enable_if_t<std::is_same_v<std::remove_const_t<Given>, TrackingSettings>> each_parameter(
    Given& s, Visit&& visit) {
  visit(Parameter{"model", "path of model.yaml, as `seatrial identify` writes it"}, s.model);
  visit(Parameter{"gains", "path of gains.yaml, as `seatrial tune` writes it; empty: parameters"},
        s.gains);
  visit(Parameter{"command_topic", "commands to the boat; empty: the vehicle's"}, s.command_topic);
  visit(Parameter{"control_in_map", "by map_pose, as references in map need it; else by odom"},
        s.control_in_map);
  visit(Parameter{"feed_forward", "through the model, besides the PID"}, s.feed_forward);
  visit(Parameter{"rate", "of the commands [Hz]; 0: as in the gains", 0.0, 200.0}, s.rate);
  visit(Parameter{"timeout", "age of odometry from which commands are zero [s]", 0.02, 5.0},
        s.timeout);
  visit(Parameter{"reference_timeout", "the same of the reference [s]", 0.02, 60.0},
        s.reference_timeout);
  visit(Parameter{"position_uncertainty",
                  "standard deviation of map_pose from which commands are zero [m]", 0.001, 1000.0},
        s.position_uncertainty);
  visit(Parameter{"heading_uncertainty", "the same of its heading [rad]", 0.001, 7.0},
        s.heading_uncertainty);
  visit(Parameter{"proportional", "surge, sway, yaw: commands per m, m, rad"}, s.proportional);
  visit(Parameter{"integral", "per m s, m s, rad s"}, s.integral);
  visit(Parameter{"derivative", "per m/s, m/s, rad/s"}, s.derivative);
  visit(Parameter{"authority", "[m/s^2, m/s^2, rad/s^2] by an axis command of 1"}, s.authority);
  visit(Parameter{"mix", "an input's shares of the axis commands, three each"}, s.mix);
  visit(Parameter{"guidance",
                  "of a boat without sway thrust: time [s], radius [m], slowest, fastest [m/s], "
                  "approach [s]; empty: none"},
        s.guidance);
  visit(Parameter{"lead", "by which feed-forward looks ahead [s]", 0.0, 10.0}, s.lead);
  visit(Parameter{"limit", "of each input, 1: full", 1e-6, 1.0}, s.limit);
  visit(Parameter{"allocation",
                  "vehicle: the boat's own; a scheme of `seatrial allocate`: to its thrusters, "
                  "with the gains' numbers; empty: as the gains say"},
        s.allocation);
  visit(Parameter{"allocation_rank", "of surge, sway, yaw at the limits, 0 is served first"},
        s.allocation_rank);
  visit(Parameter{"allocation_hysteresis", "of wrench, before a thruster changes its side", 0.0,
                  10.0},
        s.allocation_hysteresis);
  visit(Parameter{"allocation_thrusters",
                  "six each: wrench by a thrust of 1 (three), limit, idling forward, astern"},
        s.allocation_thrusters);
}

}  // namespace seatrial::ros
