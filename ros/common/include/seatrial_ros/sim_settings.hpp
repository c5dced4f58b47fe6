// SPDX-License-Identifier: MIT
// The simulator node's parameters, for ROS 1 and ROS 2 alike.
#pragma once
#include "seatrial_ros/settings.hpp"

namespace seatrial::ros {

struct SimSettings {
  std::string models;
  std::string scene;
  std::string map_frame = "map";
  std::string base_frame = "base_link";
  std::string laser_frame = "laser";
  double rate = 50.0;
  double real_time_factor = 1.0;
  double seed = 0.0;
  bool publish_clock = true;
};

/// As of `Settings`.
template <class Given, class Visit>
std::enable_if_t<std::is_same_v<std::remove_const_t<Given>, SimSettings>> each_parameter(
    Given& s, Visit&& visit) {
  visit(Parameter{"models", "path of a model.yaml, or several with commas between: a boat each"},
        s.models);
  visit(Parameter{"scene", "path of a scene.yaml: walls, current, sensors; empty: open water"},
        s.scene);
  visit(Parameter{"map_frame", "frame of poses and truth"}, s.map_frame);
  visit(Parameter{"base_frame", "frame of the boat, at its origin"}, s.base_frame);
  visit(Parameter{"laser_frame", "frame of the LiDAR"}, s.laser_frame);
  visit(Parameter{"rate", "of the truth [Hz]", 0.1, 1000.0}, s.rate);
  visit(Parameter{"real_time_factor", "simulated seconds in a second", 0.01, 100.0},
        s.real_time_factor);
  visit(Parameter{"seed", "of the sensors' noise, a whole number", 0.0, 1e9}, s.seed);
  visit(Parameter{"publish_clock", "/clock; the others then have use_sim_time"}, s.publish_clock);
}

}  // namespace seatrial::ros
